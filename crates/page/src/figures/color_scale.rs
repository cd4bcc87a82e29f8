//! Values to bands of color, and the bar that explains them.

use super::axis::{Axis, ColorScale};
use super::canvas::{Anchor, Canvas, INK, LABEL_SIZE, TEXT_SIZE, TITLE_PX, WIDTH_PX, text_width_px};
use super::panels::RIGHT_PX;
use super::scale::{number_text, ratio_text, step_text};

/// About as many bands.
const BANDS: usize = 10;
/// Borders within one power of ten, by what they are times of it.
const ROUND: [f64; 3] = [1.0, 2.0, 5.0];
pub(super) const BAR_WIDTH_PX: f64 = 20.0;
/// From one line of a label to the next.
pub(super) const LINE_PX: f64 = 15.0;

/// Bands of color over values, dark to light.
#[derive(Clone, Debug)]
pub struct Bands {
    /// In the order of the colors, dark to light.
    borders: Vec<f64>,
    texts: Vec<String>,
    /// What the bar is labelled.
    label: String,
    /// Whether some values lie beyond the last border.
    exceeded: bool,
    /// 1, or -1 where the highest value has the first color.
    sign: f64,
}

impl Bands {
    /// The bands of these values, of which those that are not finite are left out.
    pub fn of(axis: &Axis, values: impl IntoIterator<Item = f64>) -> Self {
        let is_from_highest = matches!(axis.colors(), ColorScale::NearHighest | ColorScale::RatiosFromHighest);
        let sign = if is_from_highest { -1.0 } else { 1.0 };
        let mut ranked: Vec<f64> = values.into_iter().filter(|z| z.is_finite()).map(|z| sign * z).collect();
        ranked.sort_by(f64::total_cmp);
        let is_flat = ranked.first() == ranked.last();
        match axis.colors() {
            ColorScale::RatiosFromLowest | ColorScale::RatiosFromHighest
                if let Some(borders) = round_ratios(&ranked, sign) =>
            {
                Self::ratios(axis, borders, sign)
            }
            ColorScale::NearLowest | ColorScale::NearHighest if !is_flat => Self::near_first(axis, &ranked, sign),
            ColorScale::EqualShares if !is_flat => Self::equal_shares(axis, &ranked),
            _ => Self::linear(axis, &ranked, sign),
        }
    }

    fn linear(axis: &Axis, ranked: &[f64], sign: f64) -> Self {
        let mut shown = ranked.to_vec();
        if let (Some(lowest), Some(highest)) = (ranked.first(), ranked.last()) {
            let most = ranked[(ranked.len() - 1) * 4 / 5];
            if !axis.has_range() && most > *lowest && highest - lowest > 1.5 * (most - lowest) {
                shown.retain(|value| *value <= most);
            }
        }
        let scale = axis.scale(shown.into_iter(), BANDS);
        let borders = scale.ticks();
        // As they are shown, highest values first or last.
        let shown = if sign < 0.0 { scale.between(-scale.max, -scale.min) } else { scale };
        let texts = borders.iter().map(|border| shown.text(sign * border)).collect();
        let label = format!("{}{}", axis.label(), shown.above());
        Self { exceeded: exceeds(ranked, &borders), borders, texts, label, sign }
    }

    fn near_first(axis: &Axis, ranked: &[f64], sign: f64) -> Self {
        let first = ranked[0];
        let distances: Vec<f64> = ranked.iter().map(|value| value - first).collect();
        let steps = round_distances(&distances);
        let decimals = (-steps[0].log10() - 1e-9).ceil().clamp(0.0, 12.0) as usize;
        let (side, end, plus) = if sign > 0.0 { ("above", "lowest", "+") } else { ("below", "highest", "\u{2212}") };
        let shown_decimals = |step: &f64| (-step.log10() - 1e-9).ceil().max(0.0) as usize;
        let texts = steps.iter().map(|step| format!("{plus}{}", step_text(*step, shown_decimals(step))));
        let label = format!("{} {side} the {end}, {}", axis.label(), number_text(sign * first, decimals));
        let borders: Vec<f64> = std::iter::once(first).chain(steps.iter().map(|step| first + step)).collect();
        let texts = std::iter::once(end.to_owned()).chain(texts).collect();
        Self { exceeded: exceeds(ranked, &borders), borders, texts, label, sign }
    }

    /// Borders from the lowest value to the highest.
    fn ratios(axis: &Axis, mut borders: Vec<f64>, sign: f64) -> Self {
        if sign < 0.0 {
            borders.reverse();
        }
        let texts = borders.iter().map(|border| ratio_text(*border, &borders)).collect();
        let borders = borders.into_iter().map(|border| sign * border).collect();
        Self { borders, texts, label: axis.label().to_string(), exceeded: false, sign }
    }

    fn equal_shares(axis: &Axis, ranked: &[f64]) -> Self {
        let last = ranked.len() - 1;
        let mut borders: Vec<f64> = (0..=BANDS).map(|part| ranked[part * last / BANDS]).collect();
        borders.dedup();
        let narrowest = borders.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let decimals = (-narrowest.log10()).ceil().clamp(0.0, 6.0) as usize;
        let texts = borders.iter().map(|border| number_text(*border, decimals)).collect();
        let label = format!("{}, equally many cells in each color", axis.label());
        Self { borders, texts, label, exceeded: false, sign: 1.0 }
    }

    /// The width of the widest text at a border.
    pub(super) fn text_width_px(&self) -> f64 {
        self.texts.iter().map(|text| text_width_px(text, TEXT_SIZE)).fold(0.0, f64::max)
    }

    /// The label of the bar in lines that are hardly longer than this.
    pub(super) fn label_lines(&self, longest_px: f64) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in self.label.split(' ') {
            match lines.last_mut() {
                Some(line) if text_width_px(&format!("{line} {word}"), LABEL_SIZE) <= longest_px => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }

    /// How many bands there are.
    pub(super) fn count(&self) -> usize {
        self.borders.len().saturating_sub(1)
    }

    /// In terms of [`Bands::rank`], from the first color to the last.
    pub(super) fn borders(&self) -> &[f64] {
        &self.borders
    }

    /// What is written at a border.
    pub(super) fn text(&self, border: usize) -> &str {
        &self.texts[border]
    }

    /// A value, turned so that it grows from the first color to the last.
    pub(super) fn rank(&self, value: f64) -> f64 {
        self.sign * value
    }

    /// The color of a band.
    pub(super) fn color(&self, band: usize) -> String {
        format!("#{:x}", colorous::VIRIDIS.eval_continuous((band as f64 + 0.5) / self.count() as f64))
    }

    /// The color of a value: that of the first or the last band beyond them.
    pub fn color_of(&self, value: f64) -> String {
        let rank = self.rank(value);
        let passed = self.borders.iter().filter(|border| **border <= rank).count();
        self.color(passed.saturating_sub(1).min(self.count().saturating_sub(1)))
    }
}

fn exceeds(ranked: &[f64], borders: &[f64]) -> bool {
    match (borders.last(), ranked.last()) {
        (Some(border), Some(highest)) => *highest > border + 1e-9 * border.abs(),
        _ => false,
    }
}

/// Round distances that grow by 2 or 2.5, the last beyond nearly all of these, which are sorted and not all zero; the
/// first leaves some of them below it.
fn round_distances(distances: &[f64]) -> Vec<f64> {
    let last = distances.len() - 1;
    let at = |share: f64| distances[((share * last as f64).round() as usize).max(1)];
    let most = distances[last];
    // A few values far out are not worth a color.
    let beyond = if most > 4.0 * at(0.95) && at(0.95) > 0.0 { at(0.95) } else { most };
    let mut exponent = beyond.log10().floor() as i32;
    let mut digit = 0;
    let round = |exponent: i32, digit: usize| ROUND[digit] * 10_f64.powi(exponent);
    while round(exponent, digit) < beyond * (1.0 - 1e-9) {
        (exponent, digit) = if digit == 2 { (exponent + 1, 0) } else { (exponent, digit + 1) };
    }
    let mut steps = vec![round(exponent, digit)];
    while steps.len() < BANDS {
        (exponent, digit) = if digit == 0 { (exponent - 1, 2) } else { (exponent, digit - 1) };
        let next = round(exponent, digit);
        if steps.len() > 1 && next <= at(0.005) {
            break;
        }
        steps.push(next);
    }
    steps.reverse();
    steps
}

/// Below this ratio of the highest to the lowest value differences tell as much.
const LEAST_RATIO: f64 = 3.0;

/// Borders within each of a few powers of ten, by what they are times of it: evenly spread, about, on a logarithmic scale.
const THIRDS: &[f64] = &ROUND;
const HALVES: &[f64] = &[1.0, 3.0];

/// Round numbers of about the same ratio from below the lowest of these values to above the highest, at most some ten: 1, 2 and 5
/// times powers of ten, 1 and 3 times, powers of ten, or one in a few of these. None where a value is not positive, or they span too
/// little.
fn round_ratios(ranked: &[f64], sign: f64) -> Option<Vec<f64>> {
    let (first, last) = (sign * ranked.first()?, sign * ranked.last()?);
    let (lowest, highest) = (first.min(last), first.max(last));
    if lowest <= 0.0 || highest < LEAST_RATIO * lowest {
        return None;
    }
    let (from, to) = ((lowest.log10() + 1e-9).floor() as i32, (highest.log10() - 1e-9).ceil() as i32);
    let decades = usize::try_from(to - from).ok()?;
    let within = match decades {
        few if few <= BANDS / THIRDS.len() => THIRDS,
        some if some <= BANDS / HALVES.len() => HALVES,
        _ => &[1.0],
    };
    let stride = decades.div_ceil(BANDS).max(1);
    let powers =
        (0..=decades.div_ceil(stride)).map(|step| Some(10_f64.powi(from + i32::try_from(step * stride).ok()?)));
    let powers = powers.collect::<Option<Vec<f64>>>()?;
    let all: Vec<f64> = powers.iter().flat_map(|power| within.iter().map(move |times| times * power)).collect();
    let covering = |all: Vec<f64>| {
        let begin = all.iter().rposition(|border| *border <= lowest * (1.0 + 1e-9))?;
        let end = all.iter().position(|border| *border >= highest * (1.0 - 1e-9))?;
        Some(all[begin..=end].to_vec())
    };
    covering(finer_near_first(&covering(all)?, sign))
}

/// Bands of the first colors that are split.
const SPLIT: usize = 2;

/// Ascending borders with others within the bands at their low end, or at the high end where the sign is negative: what is nearly as good as
/// the best is told apart.
fn finer_near_first(borders: &[f64], sign: f64) -> Vec<f64> {
    let n_bands = borders.len().saturating_sub(1);
    let is_split = |band: usize| if sign > 0.0 { band < SPLIT } else { band + SPLIT >= n_bands };
    let mut finer = Vec::new();
    for (band, pair) in borders.windows(2).enumerate() {
        finer.push(pair[0]);
        finer.extend(if is_split(band) { within(pair[0], pair[1]) } else { Vec::new() });
    }
    finer.extend(borders.last());
    finer
}

/// Round numbers between two, the first of which is round.
fn within(low: f64, high: f64) -> Vec<f64> {
    let (from, to) = (low.log10(), high.log10());
    let times: &[f64] = match to - from {
        // In the middle of several powers of ten.
        several if several > 2.5 => return vec![10_f64.powi((0.5 * (from + to)).round() as i32)],
        two if two > 1.5 => &[2.0, 5.0, 10.0, 30.0],
        one if one > 0.8 => &[2.0, 5.0],
        _ => &[1.5, 2.0, 3.0, 5.0, 7.0],
    };
    let power = 10_f64.powi((from + 1e-9).floor() as i32);
    times
        .iter()
        .map(|times| times * power)
        .filter(|one| *one > low * (1.0 + 1e-9) && *one < high * (1.0 - 1e-9))
        .collect()
}

/// The bar beside the frame of a whole figure.
pub(super) fn draw_color_bar(canvas: &mut Canvas, bands: &Bands, frame_bottom: f64) {
    let bar =
        Bar { left: RIGHT_PX + 30.0, top: TITLE_PX + 24.0, bottom: frame_bottom - 10.0, label_x: WIDTH_PX - 14.0 };
    bar.draw(canvas, bands, std::slice::from_ref(&bands.label));
}

/// Where a bar of colors stands.
pub(super) struct Bar {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
    /// Where its label runs up, or the last line of it.
    pub(super) label_x: f64,
}

impl Bar {
    /// Draws the bar with its label, and with a tip when values go on beyond it.
    pub(super) fn draw(&self, canvas: &mut Canvas, bands: &Bands, label: &[String]) {
        let count = bands.count();
        let height = (self.bottom - self.top) / count.max(1) as f64;
        for band in 0..count {
            let band_top = self.bottom - (band + 1) as f64 * height;
            canvas.rect((self.left, band_top), (BAR_WIDTH_PX, height), &bands.color(band), INK);
        }
        if bands.exceeded && count > 0 {
            let (left, right, top) = (self.left, self.left + BAR_WIDTH_PX, self.top);
            let d = format!("M{left} {top}L{right} {top}L{} {}Z", 0.5 * (left + right), top - 14.0);
            canvas.path(&d, &bands.color(count - 1), INK, 1.0);
        }
        for border in 0..bands.borders.len() {
            let y = self.bottom - border as f64 * height;
            let at = (self.left + BAR_WIDTH_PX + 6.0, y + 4.0);
            canvas.text_as(bands.text(border), at, TEXT_SIZE, Anchor::Start);
        }
        for (number, line) in label.iter().rev().enumerate() {
            let x = self.label_x - number as f64 * LINE_PX;
            canvas.vertical_text(line, (x, 0.5 * (self.top + self.bottom)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bands(colors: ColorScale, values: &[f64]) -> Bands {
        Bands::of(&Axis::new("cost", "s").with_colors(colors), values.iter().copied())
    }

    /// A narrow valley in a high plain: most values are far from the lowest.
    fn valley() -> Vec<f64> {
        (0..1000).map(|i| 4.0 + 10.0 * (1.0 - (-f64::from(i) / 100.0).exp())).collect()
    }

    fn used(bands: &Bands, values: &[f64]) -> usize {
        let colors: std::collections::BTreeSet<String> = values.iter().map(|value| bands.color_of(*value)).collect();
        colors.len()
    }

    #[test]
    fn near_the_lowest_value_bands_are_narrow() {
        let values = valley();
        let bands = bands(ColorScale::NearLowest, &values);
        let near: Vec<f64> = values.iter().copied().filter(|value| *value < 5.0).collect();
        let linear = self::bands(ColorScale::Linear, &values);
        assert!(used(&bands, &near) > used(&linear, &near), "colors where it matters");
        assert_eq!(bands.text(0), "lowest");
        assert_eq!(bands.texts.last().map(String::as_str), Some("+10"));
        assert!(bands.label.starts_with("cost (s) above the lowest, 4"), "{}", bands.label);
        assert!(bands.borders.windows(2).all(|pair| pair[0] < pair[1]), "{:?}", bands.borders);
    }

    #[test]
    fn what_is_maximized_is_darkest_where_it_is_highest() {
        let values: Vec<f64> = valley().into_iter().map(|value| -value).collect();
        let (mirrored, straight) = (bands(ColorScale::NearHighest, &values), bands(ColorScale::NearLowest, &valley()));
        for (value, mirror) in valley().into_iter().zip(values) {
            assert_eq!(mirrored.color_of(mirror), straight.color_of(value));
        }
        assert_eq!(mirrored.text(0), "highest");
        assert_eq!(mirrored.texts.last().map(String::as_str), Some("\u{2212}10"));
    }

    #[test]
    fn equal_shares_hold_equally_many_values() {
        let values = valley();
        let bands = bands(ColorScale::EqualShares, &values);
        for band in 0..bands.count() {
            let color = bands.color(band);
            let n = values.iter().filter(|value| bands.color_of(**value) == color).count();
            assert!((99..=101).contains(&n), "{n} of {} in band {band}", values.len());
        }
    }

    #[test]
    fn the_same_ratio_is_as_many_colors_everywhere_but_near_the_best() {
        let decades = bands(ColorScale::RatiosFromLowest, &[3e-9, 1e-6, 2e-3]);
        assert_eq!(
            decades.texts.first().zip(decades.texts.last()),
            Some((&"2e\u{2212}9".into(), &"1e\u{2212}2".into()))
        );
        let band = |value: f64| (0..decades.count()).find(|&band| decades.color(band) == decades.color_of(value));
        assert_eq!((band(1.5e-9), band(3e-9), band(3e-8), band(3e-4)), (Some(0), Some(0), Some(3), Some(8)));
        let mirrored = bands(ColorScale::RatiosFromHighest, &[3e-9, 1e-6, 2e-3]);
        let few = [0, 1, 2].map(|band| mirrored.text(band));
        assert_eq!(few, ["2e\u{2212}3", "1e\u{2212}3", "5e\u{2212}4"], "all as powers of ten");
        assert_eq!((mirrored.color_of(7e-3), mirrored.color_of(1.5e-4)), (mirrored.color(0), mirrored.color(3)));
        let some = bands(ColorScale::RatiosFromLowest, &[1.0, 4000.0]);
        assert_eq!(
            some.texts,
            ["1", "1.5", "2", "3", "5", "7", "10", "30", "100", "300", "1000", "3000", "10000"],
            "no power of ten in one color, and the first more finely"
        );
        assert_eq!(bands(ColorScale::RatiosFromLowest, &[3.0, 45.0]).texts, ["3", "5", "7", "10", "20", "50"]);
        assert!(bands(ColorScale::RatiosFromLowest, &[1e-90, 1e90]).count() <= 12);
        let eleven = bands(ColorScale::RatiosFromLowest, &[1.0, 0.9e11]);
        assert!(eleven.texts[..5] == ["1e0", "2e0", "5e0", "1e1", "3e1"] && eleven.count() <= 14, "{:?}", eleven.texts);
        for exponent in 1..=10 {
            let bands = bands(ColorScale::RatiosFromLowest, &[1.0, 0.9 * 10_f64.powi(exponent)]);
            let ratios: Vec<f64> = bands.borders.windows(2).map(|pair| (pair[1] / pair[0]).ln()).collect();
            let ends = |ratios: &[f64]| {
                ratios.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), one| (low.min(*one), high.max(*one)))
            };
            // Near the best some are split: there no color is of a factor of more than 2.5.
            let n_fine = ratios.iter().position(|ratio| *ratio > 2.6_f64.ln()).unwrap_or(ratios.len());
            let (fine, rest) = (ends(&ratios[..n_fine]), ends(&ratios[n_fine..]));
            assert!(n_fine >= 3 && fine.1 < 2.6_f64.ln(), "{exponent}: {:?}", bands.borders);
            assert!(n_fine == ratios.len() || rest.1 < 1.5 * rest.0, "{exponent}: {:?}", bands.borders);
            assert!((3..=14).contains(&bands.count()), "{exponent}: {:?}", bands.borders);
        }
        assert_eq!(bands(ColorScale::RatiosFromLowest, &[-1.0, 4.0]).texts.first(), Some(&"\u{2212}1.0".into()));
    }

    #[test]
    fn long_labels_are_broken_between_words() {
        let name = "power of the whole drive train at full load";
        let axis = Axis::new(name, "kg m2/s3").with_colors(ColorScale::NearLowest);
        let lines = Bands::of(&axis, [0.0, 1.0, 2.0]).label_lines(350.0);
        assert_eq!(lines, ["power of the whole drive train at full load", "(kg m2/s3) above the lowest, 0"]);
        assert_eq!(bands(ColorScale::NearLowest, &[0.0, 1.0, 2.0]).label_lines(350.0).len(), 1);
    }

    #[test]
    fn values_that_are_few_equal_or_none_are_colored() {
        for colors in [
            ColorScale::Linear,
            ColorScale::NearLowest,
            ColorScale::NearHighest,
            ColorScale::EqualShares,
            ColorScale::RatiosFromLowest,
            ColorScale::RatiosFromHighest,
        ] {
            for values in [vec![], vec![f64::NAN], vec![3.0], vec![3.0; 9], vec![0.0, 1e-9], vec![1.0, 1e9, f64::NAN]] {
                let bands = bands(colors, &values);
                assert!(bands.count() >= 1, "{colors:?} of {values:?}");
                assert_eq!(bands.texts.len(), bands.borders.len());
                assert!(values.iter().all(|value| bands.color_of(*value).len() == 7), "{colors:?} of {values:?}");
            }
        }
    }
}
