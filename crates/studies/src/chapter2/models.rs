//! The three models of Table 2, released with a twist and without a controller: Figures 11 and 12.

use anyhow::{Context as _, Result};
use bat_dynamics::{Flow, FlowHistory, FlowKnot, Transition};
use scaling::DocumentOptions;
use water_channel::{
    Control, Departure, Error, FlightRequest, FlightSettings, Rig, RigFile, TestProfile, fly_logged, open_loop_modes,
};

use super::file::{Model, Setup};
use crate::bat::STAND_IN;

/// What is taken from Table 2 and what from the laws of scaling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Case {
    /// Everything by the scale factor.
    Similar,
    /// Tether, speed and time scale as printed; masses by the scale factor.
    Rounded,
    /// As `Rounded` with the masses as printed, the displaced volume in proportion to them.
    PrintedMasses,
    /// As `PrintedMasses` with the displaced volume by the scale factor.
    PrintedMassesInSimilarHulls,
}

impl Case {
    /// The cases in which every model floats.
    pub(crate) const FLOWN: [Self; 3] = [Self::Similar, Self::Rounded, Self::PrintedMasses];

    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Similar => "similar: everything by the scale factor",
            Self::Rounded => "printed lengths, speeds and time scales, masses by the scale factor",
            Self::PrintedMasses => "printed masses (displaced volume in proportion)",
            Self::PrintedMassesInSimilarHulls => "printed masses in hulls of similar shape",
        }
    }
}

/// The flight of one model after its release.
#[derive(Clone, Debug)]
pub(crate) struct Release {
    pub(crate) model: String,
    pub(crate) time_s: Vec<f64>,
    pub(crate) heading_rad: Vec<f64>,
    pub(crate) lateral_m: Vec<f64>,
    /// a of (18): normalized over absolute time.
    pub(crate) time_scale: f64,
    /// L_t, by which the lateral position is divided.
    pub(crate) length_m: f64,
    /// Period of the slowest oscillation of the body about its trim.
    pub(crate) period_s: f64,
}

impl Release {
    pub(crate) fn normalized_time(&self) -> Vec<f64> {
        self.time_s.iter().map(|t| self.time_scale * t).collect()
    }

    pub(crate) fn normalized_lateral(&self) -> Vec<f64> {
        self.lateral_m.iter().map(|y| y / self.length_m).collect()
    }
}

/// The largest distance of the models' curves from the reference model's, as a share of that one's peak.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Departures {
    pub(crate) heading: f64,
    pub(crate) lateral: f64,
}

/// The releases of all models in one case.
#[derive(Clone, Debug)]
pub(crate) struct Releases {
    pub(crate) case: Case,
    /// In the order of Table 2.
    pub(crate) models: Vec<Release>,
    reference: usize,
}

impl Releases {
    pub(crate) fn fly(setup: &Setup, case: Case) -> Result<Self> {
        let models = setup.file.model.iter().map(|model| release(setup, model, case)).collect::<Result<Vec<_>>>()?;
        Ok(Self { case, models, reference: setup.reference })
    }

    /// How far the curves are apart in absolute time.
    pub(crate) fn apart(&self) -> Departures {
        self.departures(|release| release.time_s.clone(), |release| release.lateral_m.clone())
    }

    /// How far the curves are apart in normalized time and position.
    pub(crate) fn apart_when_normalized(&self) -> Departures {
        self.departures(Release::normalized_time, Release::normalized_lateral)
    }

    fn departures(&self, time: fn(&Release) -> Vec<f64>, lateral: fn(&Release) -> Vec<f64>) -> Departures {
        let heading: fn(&Release) -> Vec<f64> = |release| release.heading_rad.clone();
        let largest = |quantity: fn(&Release) -> Vec<f64>| {
            let reference = &self.models[self.reference];
            let (at, curve) = (time(reference), quantity(reference));
            let peak = curve.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
            let others = self.models.iter().enumerate().filter(|(k, _)| *k != self.reference);
            let distances = others.flat_map(|(_, other)| {
                let (t, y) = (time(other), quantity(other));
                let pairs: Vec<f64> = at
                    .iter()
                    .zip(&curve)
                    .filter_map(|(at, value)| Some((between(&t, &y, *at)? - value).abs()))
                    .collect();
                pairs
            });
            distances.fold(0.0, f64::max) / peak
        };
        Departures { heading: largest(heading), lateral: largest(lateral) }
    }
}

/// Linear interpolation; nothing beyond the ends, of which rounding is forgiven.
fn between(x: &[f64], y: &[f64], at: f64) -> Option<f64> {
    let (first, last) = (*x.first()?, *x.last()?);
    let slack = 1e-9 * (last - first);
    if at < first - slack || at > last + slack {
        return None;
    }
    let above = x.partition_point(|x| *x < at).clamp(1, x.len() - 1);
    let share = (at - x[above - 1]) / (x[above] - x[above - 1]);
    // A sample that is hit to rounding is that sample.
    match share {
        share if share.abs() < 1e-6 => Some(y[above - 1]),
        share if (share - 1.0).abs() < 1e-6 => Some(y[above]),
        share => Some(y[above - 1] + share * (y[above] - y[above - 1])),
    }
}

/// The rig of a model.
fn rig(setup: &Setup, model: &Model, case: Case) -> Result<Rig> {
    let law = setup.law_to(model)?;
    let converted = law.convert_document(&setup.units, &setup.texts[0].text, &DocumentOptions::default())?;
    let mut rig = RigFile::parse(&converted.text)?.rig;
    if case == Case::Similar {
        return Ok(rig);
    }
    let reference = &setup.file.model[setup.reference];
    let ratio = |key: &str, of: fn(&Model) -> &String| -> Result<f64> {
        Ok(model.number(key, of(model))? / reference.number(key, of(reference))?)
    };
    let base = &setup.rig.rig;
    rig.set_points.altitude_m = base.set_points.altitude_m * ratio("tether_cm", |m| &m.tether_cm)?;
    if matches!(case, Case::PrintedMasses | Case::PrintedMassesInSimilarHulls) {
        let (mass, length) = (ratio("mass_g", |m| &m.mass_g)?, ratio("scale_factor", |m| &m.scale_factor)?);
        let (body, like) = (&mut rig.plant.body, &base.plant.body);
        body.mass_kg = like.mass_kg * mass;
        if case == Case::PrintedMasses {
            body.volume_m3 = like.volume_m3 * mass;
        }
        // The same distribution of mass in a body of another mass and length.
        let inertia = mass * length * length;
        body.inertia_xx_kg_m2 = like.inertia_xx_kg_m2 * inertia;
        body.inertia_yy_kg_m2 = like.inertia_yy_kg_m2 * inertia;
        body.inertia_zz_kg_m2 = like.inertia_zz_kg_m2 * inertia;
        body.inertia_xz_kg_m2 = like.inertia_xz_kg_m2 * inertia;
    }
    Ok(rig)
}

/// The speed of the flow: printed, or by the scale factor from the reference model's.
fn speed_m_s(setup: &Setup, model: &Model, case: Case) -> Result<f64> {
    let printed = |model: &Model| -> Result<f64> { Ok(0.01 * model.number("speed_cm_s", &model.speed_cm_s)?) };
    match case {
        Case::Similar => {
            let factor = setup.law_to(model)?.rule("V")?.factor;
            Ok(factor.to_f64() * printed(&setup.file.model[setup.reference])?)
        }
        Case::Rounded | Case::PrintedMasses | Case::PrintedMassesInSimilarHulls => printed(model),
    }
}

/// Time scale a and tether length of a model: as printed, or by the scale factor from the reference model's.
fn scales(setup: &Setup, model: &Model, case: Case) -> Result<(f64, f64)> {
    let printed = |model: &Model| -> Result<(f64, f64)> {
        Ok((model.number("time_scale", &model.time_scale)?, 0.01 * model.number("tether_cm", &model.tether_cm)?))
    };
    if case != Case::Similar {
        return printed(model);
    }
    let law = setup.law_to(model)?;
    let (time_scale, length_m) = printed(&setup.file.model[setup.reference])?;
    Ok((time_scale / law.rule("t")?.factor.to_f64(), length_m * law.rule("L_t")?.factor.to_f64()))
}

fn release(setup: &Setup, model: &Model, case: Case) -> Result<Release> {
    let context = || format!("{} ({})", model.name, case.words());
    let flow = Flow::straight(speed_m_s(setup, model, case)?);
    let request = FlightRequest { rig: rig(setup, model, case)?, fidelity: STAND_IN };
    let profile = test(setup, model, flow)?;
    let settings = FlightSettings::with_steps(setup.file.release.steps_per_sample);
    let (flight, log) = fly_logged(&request, &profile, &settings, 1).with_context(context)?;
    flight.with_context(context)?;
    let modes = open_loop_modes(&request, &[flow]).with_context(context)?.remove(0).modes;
    let swing = modes.modes.iter().find(|mode| mode.eigenvalue.im > 0.0).with_context(context)?;
    let (time_scale, length_m) = scales(setup, model, case)?;
    let column = |f: fn(&water_channel::LogRow) -> f64| -> Vec<f64> { log.rows.iter().map(f).collect() };
    Ok(Release {
        model: model.name.clone(),
        time_s: column(|row| row.time_s),
        heading_rad: column(|row| row.heading_rad),
        lateral_m: column(|row| row.lateral_m),
        time_scale,
        length_m,
        period_s: core::f64::consts::TAU / swing.eigenvalue.im,
    })
}

/// The release of a model: as long as the reference model's in normalized time.
fn test(setup: &Setup, model: &Model, flow: Flow) -> Result<TestProfile> {
    let release = setup.file.release;
    let time = setup.law_to(model)?.rule("t")?.factor.to_f64();
    let knots = vec![FlowKnot { from_s: 0.0, flow, transition: Transition::Step }];
    let start = Departure { twist_rad: release.twist_deg.to_radians(), ..Departure::default() };
    let test = TestProfile::new(release.duration_s * time, FlowHistory::new(knots)?, Vec::new())?;
    Ok(test.with_control(Control::OpenLoop).with_start(start)?)
}

/// What a model of the printed mass does in a hull that is similar to the reference's: displaced mass in kg, and why there
/// is no trim, if there is none.
pub(crate) fn in_a_similar_hull(setup: &Setup, model: &Model) -> Result<(f64, Option<String>)> {
    let case = Case::PrintedMassesInSimilarHulls;
    let rig = rig(setup, model, case)?;
    let displaced_kg = rig.plant.fluid.density_kg_m3 * rig.plant.body.volume_m3;
    let flow = Flow::straight(speed_m_s(setup, model, case)?);
    match open_loop_modes(&FlightRequest { rig, fidelity: STAND_IN }, &[flow]) {
        Ok(_) => Ok((displaced_kg, None)),
        Err(Error::Plant(bat_dynamics::Error::NoTrim(reason))) => Ok((displaced_kg, Some(reason.to_string()))),
        Err(error) => Err(error).with_context(|| model.name.clone()),
    }
}
