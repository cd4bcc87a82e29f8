//! Settings as they are typed: `spring=21000,damper=1500`.

use std::collections::BTreeMap;

use anyhow::{Result, anyhow, bail, ensure};
use design_space::Region;

use crate::problem::parse_setting;

/// The settings that are named, each at most once.
pub(crate) fn some(text: &str, region: &Region) -> Result<BTreeMap<String, f64>> {
    let names = || region.parameters().iter().map(|p| format!("`{}`", p.name())).collect::<Vec<_>>().join(", ");
    let mut settings = BTreeMap::new();
    for part in text.split(',').filter(|part| !part.trim().is_empty()) {
        let Some((name, value)) = part.split_once('=') else {
            bail!("`{part}` is no setting, expected name=value");
        };
        let name = name.trim();
        let index = region
            .index_of(name)
            .ok_or_else(|| anyhow!("no parameter is called `{name}`, expected one of {}", names()))?;
        let parameter = &region.parameters()[index];
        let number = parameter.choices().is_none().then(|| value.trim().strip_suffix(parameter.unit())).flatten();
        let value = parse_setting(parameter, number.unwrap_or(value).trim())
            .map_err(|expected| anyhow!("`{name}` is `{value}`, expected {expected}"))?;
        ensure!(settings.insert(name.to_owned(), value).is_none(), "`{name}` comes twice");
    }
    Ok(settings)
}

/// A value for every parameter, in order.
pub(crate) fn all(text: &str, region: &Region) -> Result<Vec<f64>> {
    let settings = some(text, region)?;
    let value = |parameter: &design_space::Parameter| {
        settings.get(parameter.name()).copied().ok_or_else(|| anyhow!("no value of `{}` in `{text}`", parameter.name()))
    };
    region.parameters().iter().map(value).collect()
}
