//! Rigs in whole runs.

mod faults;
