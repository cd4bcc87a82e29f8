//! Claims of the command, each made as a person in a shell would make it.
