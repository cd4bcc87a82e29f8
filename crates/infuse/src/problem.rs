//! Which parameters belong to the plant and which to the controller.

use design_space::Region;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::checks::check_length;
use crate::codesign::Strategy;

/// What a parameter is part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Something that is built: changed with a saw.
    Plant,
    /// Something that is set: changed with a keyboard.
    Controller,
}

/// A region of design parameters, each with its role: any number of each, at least one in total.
///
/// The optimizers of this crate move every parameter continuously between its bounds; the levels of
/// a [`design_space::Parameter`] are not used by them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedProblem")]
pub struct CodesignProblem {
    region: Region,
    roles: Vec<Role>,
}

impl CodesignProblem {
    /// A problem over this region, with one role per parameter in the region's order.
    ///
    /// # Errors
    ///
    /// [`Error::WrongLength`], [`Error::DesignSpace`] for a parameter that is a choice: nothing is between two of them.
    pub fn new(region: Region, roles: Vec<Role>) -> Result<Self, Error> {
        check_length("roles", region.n_parameters(), roles.len())?;
        region.parameters().iter().try_for_each(design_space::Parameter::check_number)?;
        Ok(Self { region, roles })
    }

    /// The parameters and their bounds.
    #[must_use]
    pub fn region(&self) -> &Region {
        &self.region
    }

    /// The role of each parameter, in the region's order.
    #[must_use]
    pub fn roles(&self) -> &[Role] {
        &self.roles
    }

    /// How many parameters there are.
    #[must_use]
    pub fn n_parameters(&self) -> usize {
        self.roles.len()
    }

    /// Positions of the parameters with this role, ascending.
    #[must_use]
    pub fn indices(&self, role: Role) -> Vec<usize> {
        (0..self.roles.len()).filter(|&index| self.roles[index] == role).collect()
    }

    /// A list with `plant` at each plant parameter and `controller` at each controller parameter:
    /// the two trust factors R_p and R_c of (27) as [`Settings::trust`](crate::gradient::Settings::trust).
    #[must_use]
    pub fn per_role(&self, plant: f64, controller: f64) -> Vec<f64> {
        let value = |role: &Role| match role {
            Role::Plant => plant,
            Role::Controller => controller,
        };
        self.roles.iter().map(value).collect()
    }

    pub(crate) fn check_strategy(&self, strategy: Strategy) -> Result<(), Error> {
        let n_plant = self.indices(Role::Plant).len();
        let n_controller = self.n_parameters() - n_plant;
        if strategy == Strategy::Simultaneous || (n_plant > 0 && n_controller > 0) {
            return Ok(());
        }
        Err(Error::NeedsPlantAndController { strategy, n_plant, n_controller })
    }
}

/// A problem as it stands in a file, before the roles are counted.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "CodesignProblem")]
struct UncheckedProblem {
    region: Region,
    roles: Vec<Role>,
}

impl TryFrom<UncheckedProblem> for CodesignProblem {
    type Error = Error;

    fn try_from(unchecked: UncheckedProblem) -> Result<Self, Error> {
        Self::new(unchecked.region, unchecked.roles)
    }
}
