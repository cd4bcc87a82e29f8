//! The compiled half of the Python package `infuse`: what it shares with the Rust libraries, and nothing else.
//!
//! Numbers in bulk cross as numpy arrays, and what has a structure as JSON, which keeps every bit of a double. The other half, in
//! `python/infuse/`, gives them names and types. Whatever computes for long lets other Python threads run meanwhile, and
//! notices Ctrl-C.

mod arrays;
mod background;
mod designs;
mod dissertation;
mod error;
mod flights;
mod parameters;
mod pooled;
mod saved;
mod simulator;
mod surfaces;

use pyo3::prelude::*;

/// The compiled half of `infuse`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("Error", module.py().get_type::<error::Error>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<pooled::PooledLoop>()?;
    module.add_class::<dissertation::DissertationLoop>()?;
    module.add_class::<surfaces::Regression>()?;
    module.add_class::<surfaces::InverseDistance>()?;
    module.add_class::<surfaces::SquaredExponential>()?;
    module.add_class::<surfaces::GaussianProcess>()?;
    module.add_class::<flights::Channel>()?;
    module.add_function(wrap_pyfunction!(parameters::check_parameters, module)?)?;
    module.add_function(wrap_pyfunction!(parameters::coded, module)?)?;
    module.add_function(wrap_pyfunction!(parameters::natural, module)?)?;
    module.add_function(wrap_pyfunction!(designs::search, module)?)?;
    module.add_function(wrap_pyfunction!(designs::efficiency, module)?)?;
    module.add_function(wrap_pyfunction!(designs::evaluate, module)?)?;
    module.add_function(wrap_pyfunction!(designs::regressor, module)?)?;
    module.add_function(wrap_pyfunction!(designs::term_names, module)?)?;
    Ok(())
}
