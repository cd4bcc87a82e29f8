//! Whether an experiment can have been made at some settings.

use design_space::Parameter;

/// What [`is_near`] allows of a number.
pub(crate) const NEAR_THE_REGION: &str = "within half the parameter's width of its bounds";

/// Whether a natural setting can have been made. Settings may be off the grid and somewhat outside the box, as rigs are; a coded
/// coordinate beyond 2 is a slip, and so is what lies beside or between choices.
pub(crate) fn is_near(parameter: &Parameter, setting: f64) -> bool {
    match parameter.choices() {
        Some(_) => parameter.choice(setting).is_some(),
        None => parameter.coded(setting).abs() <= 2.0,
    }
}

/// What a choice can be.
#[cfg(feature = "global")]
const A_CHOICE: &str = "the place of one of its choices, from 0";

/// The name of the first parameter whose setting, of these natural ones, cannot have been made, with that setting and what can.
#[cfg(feature = "global")]
fn slip(
    settings: &[f64],
    region: &design_space::Region,
) -> Result<Option<(String, f64, &'static str)>, design_space::Error> {
    region.coded(settings)?;
    let slip = region.parameters().iter().zip(settings).find(|(parameter, value)| !is_near(parameter, **value));
    let expected = |parameter: &Parameter| match parameter.choices() {
        Some(_) => A_CHOICE,
        None => NEAR_THE_REGION,
    };
    Ok(slip.map(|(parameter, &value)| (parameter.name().to_owned(), value, expected(parameter))))
}

/// Whether an experiment outside of the campaign can have been made at these natural settings.
#[cfg(feature = "global")]
pub(crate) fn check_earlier(settings: &[f64], region: &design_space::Region) -> Result<(), crate::Error> {
    match slip(settings, region)? {
        Some((parameter, value, expected)) => Err(crate::Error::EarlierSetting { parameter, value, expected }),
        None => Ok(()),
    }
}

/// Whether a trial can have been made at these natural settings.
#[cfg(feature = "global")]
pub(crate) fn check_actual(
    id: crate::TrialId,
    settings: &[f64],
    region: &design_space::Region,
) -> Result<(), crate::Error> {
    match slip(settings, region)? {
        Some((parameter, actual, expected)) => Err(crate::Error::ActualSettingOf { id, parameter, actual, expected }),
        None => Ok(()),
    }
}
