//! Campaigns of the pooled loop: every experiment and the simulation in one surface, with a certificate.

mod apply;
mod bands;
mod best;
mod bounds;
mod buildable;
mod campaign;
mod confirm;
mod displaced;
mod drift;
mod dry;
mod failures;
mod findings;
mod given_noise;
mod hand_out;
mod method;
mod reasons;
mod report;
mod risen;
mod warnings;
mod what_if;

pub(crate) use campaign::Campaign;
