//! The measurements of a process, one entry per place.

use crate::process::places::Places;
use crate::{Data, Error};

/// Measurements grouped by place, centered and scaled.
///
/// Several at one place count as their weighted mean, with the sum of their weights, and their scatter about it tells of the
/// noise alone: nothing is lost.
#[derive(Debug, Clone, PartialEq)]
pub struct Sites {
    places: Places,
    /// Mean at each place, centered and scaled.
    means: Vec<f64>,
    weights: Vec<f64>,
    /// Of the scaled values about the means of their places.
    scatter: f64,
    n_repeats: usize,
    units: Units,
    /// Which assembly each entry belongs to, where that matters.
    assemblies: Option<Vec<usize>>,
    /// Axes that a part of the response depends on alone; none where there is no such part.
    additive: Vec<usize>,
    /// The first measurement of each entry.
    firsts: Vec<usize>,
    n_measured: usize,
}

/// These are axes of a space of so many factors, none of them twice.
pub(crate) fn check_axes(axes: &[usize], n_factors: usize) -> Result<(), Error> {
    let is_wrong = |at: usize| axes[at] >= n_factors || axes[..at].contains(&axes[at]);
    match (0..axes.len()).find(|&at| is_wrong(at)) {
        Some(at) => {
            let expected = "the number of an axis, from 0, each once";
            Err(Error::Parameter { name: "axis of the additive part", value: axes[at] as f64, expected })
        }
        None => Ok(()),
    }
}

/// Where zero and one lie for a process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Units {
    /// Mean of the values.
    pub(crate) center: f64,
    /// Their standard deviation.
    pub(crate) scale: f64,
    /// Mean of the simulated responses at the places.
    simulated_center: f64,
}

impl Units {
    /// Those in which a number stays what it is.
    pub(crate) const NONE: Self = Self { center: 0.0, scale: 1.0, simulated_center: 0.0 };

    /// What a simulated response may be off by, scaled as the values are.
    pub(crate) fn deviation(&self, d: f64) -> f64 {
        d / self.scale
    }

    /// A simulated response, centered and scaled as the values are.
    pub(crate) fn simulated(&self, s: f64) -> f64 {
        (s - self.simulated_center) / self.scale
    }
}

impl Sites {
    /// These data, with the simulated response at each point if there is a simulation.
    ///
    /// Priors are about the mean of the values, in their standard deviation. One value, or values that are all equal, have none, and
    /// what the response varies by over its factors cannot be read from them: the standard deviation of the simulated responses is
    /// then taken, and where there is none either a millionth of the value. A process is then sure of that value everywhere. Who
    /// knows by how much responses differ says so with [`in_units`](Self::in_units):
    ///
    /// ```
    /// use surface::Data;
    /// use surface::process::{AveragedProcess, Places, SamplerSettings, Sites};
    ///
    /// let one = Sites::new(&Data::new(1, vec![0.0], vec![5.0])?, None)?;
    /// let elsewhere = Places::new(1, &[0.9])?;
    /// let deviation = |sites: Sites| -> Result<f64, surface::Error> {
    ///     let process = AveragedProcess::new(sites, &SamplerSettings::default())?;
    ///     Ok(process.marginals(&elsewhere)?.variances[0].sqrt())
    /// };
    /// assert!(deviation(one.clone())? < 1e-4, "far too sure");
    /// // Responses are known to be about 4, give or take 2.
    /// assert!(deviation(one.in_units(4.0, 2.0)?)? > 0.5);
    /// # Ok::<(), surface::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Length`] unless there is one simulated response per point, [`Error::Value`].
    pub fn new(data: &Data, simulated: Option<&[f64]>) -> Result<Self, Error> {
        Self::grouped(data, simulated, None)
    }

    /// The same where measurements come in assemblies: whatever was put together anew has an error of its own, which all
    /// measurements share that were made before it was taken apart (a whole plot of a split-plot design). `assemblies` names
    /// that of each point by any number.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new), [`Error::Length`] unless there is one assembly per point.
    pub fn in_assemblies(data: &Data, simulated: Option<&[f64]>, assemblies: &[usize]) -> Result<Self, Error> {
        if assemblies.len() != data.n_points() {
            return Err(Error::Length { name: "assemblies", expected: data.n_points(), found: assemblies.len() });
        }
        Self::grouped(data, simulated, Some(assemblies))
    }

    fn grouped(data: &Data, simulated: Option<&[f64]>, assemblies: Option<&[usize]>) -> Result<Self, Error> {
        if let Some(simulated) = simulated.filter(|simulated| simulated.len() != data.n_points()) {
            let (expected, found) = (data.n_points(), simulated.len());
            return Err(Error::Length { name: "simulated responses", expected, found });
        }
        let groups = match assemblies {
            None => data.sites(),
            Some(of) => data.sites().into_iter().flat_map(|site| by_assembly(site, of)).collect(),
        };
        let coordinates: Vec<f64> = groups.iter().flat_map(|group| data.point(group[0])).copied().collect();
        let mut places = Places::new(data.n_factors(), &coordinates)?;
        if let Some(simulated) = simulated {
            places = places.with_simulated(groups.iter().map(|group| simulated[group[0]]).collect())?;
        }
        let weights: Vec<f64> =
            groups.iter().map(|group| group.iter().map(|&point| data.weights()[point]).sum()).collect();
        let means: Vec<f64> = groups
            .iter()
            .zip(&weights)
            .map(|(group, total)| group.iter().map(|&point| data.weights()[point] / total * data.values()[point]).sum())
            .collect();
        let units = Units::of(data, &places);
        let scaled = |value: f64| (value - units.center) / units.scale;
        let scatter = groups.iter().zip(&means).flat_map(|(group, mean)| {
            group
                .iter()
                .map(move |&point| data.weights()[point] * ((data.values()[point] - mean) / units.scale).powi(2))
        });
        Ok(Self {
            scatter: scatter.sum(),
            n_repeats: data.n_used() - groups.len(),
            means: means.iter().map(|&mean| scaled(mean)).collect(),
            places,
            weights,
            units,
            assemblies: assemblies.map(|of| groups.iter().map(|group| of[group[0]]).collect()),
            additive: Vec::new(),
            firsts: groups.iter().map(|group| group[0]).collect(),
            n_measured: data.n_points(),
        })
    }

    /// The same in given units: priors are then about `center`, in multiples of `scale`, instead of about the mean and in
    /// standard deviations of the values.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless the center is finite and the scale positive.
    pub fn in_units(mut self, center: f64, scale: f64) -> Result<Self, Error> {
        if !center.is_finite() {
            return Err(Error::Parameter { name: "center", value: center, expected: "a finite number" });
        }
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Error::Parameter { name: "scale", value: scale, expected: "a positive number" });
        }
        let before = self.units;
        self.means.iter_mut().for_each(|mean| *mean = (before.center + before.scale * *mean - center) / scale);
        self.scatter *= (before.scale / scale).powi(2);
        self.units = Units { center, scale, ..before };
        Ok(self)
    }

    /// The same for a response of which a part depends on these axes alone, whatever the others are: what runs have in common that
    /// agree in them.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for an axis that is not there, or twice.
    pub fn with_additive(self, axes: Vec<usize>) -> Result<Self, Error> {
        check_axes(&axes, self.places.n_factors())?;
        Ok(Self { additive: axes, ..self })
    }

    /// The same where the simulated responses are not quite known, see [`Places::with_deviations`]; each column has one per
    /// measurement.
    ///
    /// # Errors
    ///
    /// Those of [`Places::with_deviations`].
    pub fn with_deviations(mut self, deviations: &[Vec<f64>]) -> Result<Self, Error> {
        let (expected, mut columns) = (self.n_measured, Vec::with_capacity(deviations.len()));
        for column in deviations {
            if column.len() != expected {
                return Err(Error::Length { name: "deviations of simulated responses", expected, found: column.len() });
            }
            columns.push(self.firsts.iter().map(|&first| column[first]).collect());
        }
        self.places = self.places.with_deviations(columns)?;
        Ok(self)
    }

    /// The same where the simulation tells of some places less than of others, see [`Places::with_unknown`]; one per measurement, or
    /// none at all where all is known.
    ///
    /// # Errors
    ///
    /// Those of [`Places::with_unknown`].
    pub fn with_unknown(mut self, unknown: &[f64]) -> Result<Self, Error> {
        if unknown.is_empty() {
            return Ok(self);
        }
        let (name, expected, found) = ("unknown parts of simulated responses", self.n_measured, unknown.len());
        if found != expected {
            return Err(Error::Length { name, expected, found });
        }
        self.places = self.places.with_unknown(self.firsts.iter().map(|&first| unknown[first]).collect())?;
        Ok(self)
    }

    /// The places, each in the position of its first measurement among those of the others.
    #[must_use]
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// Number of measurements beyond one per place.
    #[must_use]
    pub fn n_repeats(&self) -> usize {
        self.n_repeats
    }

    /// The assembly of each place, if they are told apart.
    pub(crate) fn assemblies(&self) -> Option<&[usize]> {
        self.assemblies.as_deref()
    }

    /// The axes that a part of the response depends on alone.
    pub(crate) fn additive(&self) -> &[usize] {
        &self.additive
    }

    pub(crate) fn means(&self) -> &[f64] {
        &self.means
    }

    pub(crate) fn weights(&self) -> &[f64] {
        &self.weights
    }

    pub(crate) fn scatter(&self) -> f64 {
        self.scatter
    }

    pub(crate) fn units(&self) -> Units {
        self.units
    }
}

/// The points of a site, assembly by assembly, in the order in which they come.
fn by_assembly(site: Vec<usize>, assemblies: &[usize]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for point in site {
        match groups.iter_mut().find(|group| assemblies[group[0]] == assemblies[point]) {
            Some(group) => group.push(point),
            None => groups.push(vec![point]),
        }
    }
    groups
}

impl Units {
    /// Mean and standard deviation of the values; where all are equal, those of the simulation; where that is constant too, a
    /// millionth of the value stands for the scale.
    fn of(data: &Data, places: &Places) -> Self {
        let used =
            || data.values().iter().zip(data.weights()).filter(|(_, weight)| **weight > 0.0).map(|(value, _)| *value);
        let [center, spread] = mean_and_spread(used());
        let simulated = places.simulated().map_or([0.0; 2], |all| mean_and_spread(all.iter().copied()));
        // What rounding alone makes of equal values.
        let tiny = 1e-13 * center.abs();
        let scale = [spread, simulated[1], 1e-6 * center.abs(), 1.0];
        let scale = scale.into_iter().find(|&scale| scale > tiny && scale > 0.0).unwrap_or(1.0);
        Self { center, scale, simulated_center: simulated[0] }
    }
}

fn mean_and_spread(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let n = values.clone().count() as f64;
    let mean = values.clone().map(|value| value / n).sum::<f64>();
    let spread = (values.map(|value| (value - mean).powi(2) / n).sum::<f64>()).sqrt();
    [mean, spread]
}
