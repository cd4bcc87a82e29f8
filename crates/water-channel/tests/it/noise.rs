//! Noise of bounded size: what is read in the place of a cost.

use water_channel::BoundedNoise;

/// A uniform variable within ±b has the mean 0, the variance b²/3 and the fourth moment b⁴/5.
#[test]
fn errors_are_uniform_within_their_bound() {
    let (bound, n) = (0.02, 20_000_u64);
    let noise = BoundedNoise::new(bound, 7).unwrap();
    let shares: Vec<f64> = (0..n).map(|number| noise.relative_error(number) / bound).collect();
    assert!(shares.iter().all(|share| share.abs() <= 1.0));
    for (power, expected) in [(1, 0.0), (2, 1.0 / 3.0), (3, 0.0), (4, 0.2)] {
        let mean = shares.iter().map(|share| share.powi(power)).sum::<f64>() / n as f64;
        assert!((mean - expected).abs() < 4.0 / (n as f64).sqrt(), "moment {power}: {mean}");
    }
    let neighbors = shares.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / n as f64;
    assert!(neighbors.abs() < 4.0 / 3.0 / (n as f64).sqrt(), "neighbors know nothing of each other: {neighbors}");
}

#[test]
fn errors_belong_to_seed_and_number() {
    let noise = |seed| BoundedNoise::new(0.02, seed).unwrap();
    assert_eq!(noise(1).relative_error(5).to_bits(), noise(1).relative_error(5).to_bits());
    assert_ne!(noise(1).relative_error(5).to_bits(), noise(1).relative_error(6).to_bits());
    assert_ne!(noise(1).relative_error(5).to_bits(), noise(2).relative_error(5).to_bits());
    let measured = noise(1).measured(7.0, 5);
    assert!((measured - 7.0 * (1.0 + noise(1).relative_error(5))).abs() < 1e-15, "{measured}");
    assert_eq!(BoundedNoise::new(0.0, 1).unwrap().measured(7.0, 5).to_bits(), 7f64.to_bits(), "none");
    for bound in [-0.01, 1.0, f64::NAN] {
        assert!(BoundedNoise::new(bound, 1).unwrap_err().to_string().contains("less than 1"), "{bound}");
    }
}
