//! What a campaign says goes through a file and comes back the same.

use infuse::convergence::{AssumptionReport, Bound, ErrorLevels, RegretCertificate};
use infuse::correction::{Coefficients, Gain, Law, ModelStage, Rule};
use infuse::global::reported::Dropped;
use infuse::global::{ObservedErrors, Outlook, PureError};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::global_problems::{after, planar};

#[track_caller]
fn returns<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(serde_json::from_str::<T>(&text).unwrap(), *value, "{text}");
    let other = format!("{{\"unheard_of\":1,{}", &text[1..]);
    let refused = serde_json::from_str::<T>(&other).map_err(|error| error.to_string());
    assert!(refused.as_ref().is_err_and(|said| said.contains("unheard_of")), "{other}: {refused:?}");
}

#[test]
fn reports_of_a_campaign_return_from_json() {
    let campaign = after(4, planar().1);
    let noise = PureError::of_readings([0.1, 0.4, 0.3].map(|cost| (vec![1.0], cost))).unwrap();
    returns::<PureError>(&noise);
    returns::<Outlook>(&campaign.outlook(50, Some(noise)).unwrap().unwrap());
    let dropped = campaign.grid().cells().find_map(|cell| campaign.why_dropped(cell)).unwrap();
    returns::<Dropped>(&dropped);
    let observed = campaign.observed_certificate().unwrap().unwrap();
    returns::<ObservedErrors>(&observed);
    returns::<RegretCertificate>(&observed.certificate);
}

#[test]
fn bounds_and_what_they_rest_on_return_from_json() {
    let report = AssumptionReport::new(&[0.1, 0.3], &[0.2, 0.1, 0.4], 0.1).unwrap();
    assert_eq!((report.simulation.len(), report.experiment.len()), (1, 1), "something grew in each");
    returns(&report);
    let bound = Bound::new(Rule::new(Law::ProofRecursion, Gain::constant(0.5).unwrap()), ModelStage::Corrected);
    returns(&bound);
    returns(&bound.after(3));
    returns(&ErrorLevels::new(1.0, 0.1, 0.2).unwrap());
    returns(&Coefficients { experiment: vec![0.5, 0.25], simulation: vec![0.1, 0.15] });
}

#[test]
fn what_cannot_be_is_refused_when_it_is_read() {
    let refused = |text: &str| serde_json::from_str::<PureError>(text).unwrap_err().to_string();
    let negative = refused(r#"{"variance":-0.1,"degrees_of_freedom":2}"#);
    assert!(
        negative.starts_with("setting `variance` is -0.1, expected a finite number, zero or positive"),
        "{negative}"
    );
    let none = refused(r#"{"variance":0.1,"degrees_of_freedom":0}"#);
    assert!(none.starts_with("setting `degrees_of_freedom` is 0, expected at least 1"), "{none}");
    let levels = serde_json::from_str::<ErrorLevels>(r#"{"gap":1.0,"simulation":-1.0,"experiment":0.2}"#);
    let levels = levels.unwrap_err().to_string();
    assert!(levels.starts_with("setting `simulation` is -1.0, expected a finite number"), "{levels}");
}
