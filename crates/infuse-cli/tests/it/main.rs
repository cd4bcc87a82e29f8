//! Claims of the command, each made as a person in a shell would make it.

mod quarter_car;
