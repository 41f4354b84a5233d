//! Faults in whole runs.
