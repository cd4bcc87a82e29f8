//! Claims of the command, each made as a person in a shell would make it.

#![expect(clippy::unwrap_used, clippy::missing_assert_message, reason = "the helpers of tests fail like tests")]

mod campaigns;
mod careful;
mod checking;
mod constraints;
mod dissertation;
mod drifts;
mod faults;
mod interruptions;
mod journals;
mod kills;
mod logarithms;
mod long_tables;
mod memory;
mod mixed;
mod plants;
mod pooled;
mod pooled_report;
mod problems;
mod programs;
mod queued_experiments;
mod queues;
mod report;
mod report_page;
mod rig;
mod rough;
mod schedulers;
mod serve;
mod serve_browser;
mod served;
mod sheets;
mod slurm;
mod tables;
mod undoing;
mod without_simulation;
mod workbooks;
