//! Why a recorded run cannot be repeated.

use record::reader::RecordError;

/// Why a recorded run cannot be repeated.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RerunError {
    /// The rest of the record is unreadable.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    /// The record has no inputs.
    #[error("the record has no bytes and no frames")]
    #[diagnostic(help("record a run with `hil run PLAN --record full`"))]
    NoBytes,
    /// No device is under test in this process or as a program.
    #[error("this run has no program under test to start again")]
    #[diagnostic(help("devices are not rerun"))]
    NobodyUnderTest,
    /// A program under test could not be started.
    #[error("{why}")]
    #[diagnostic(help("a path in a command starts from the folder in which hil is called"))]
    NotStarted {
        /// The program, and why.
        why: String,
    },
    /// The machine stalled, or its clock jumped: when the device received its inputs is not in the record.
    #[error(
        "the machine of the device under test had a fault at {at_s} s: when it heard what is not known"
    )]
    #[diagnostic(help("run the plan again without faults of the host"))]
    HostFault {
        /// Time of the fault, s.
        at_s: f64,
    },
    /// A line had a fault in real time: which of the outputs it struck is not in the record.
    #[error(
        "a line of the device under test had a fault in real time, at {at_s} s: what it struck is not known"
    )]
    #[diagnostic(help("run the plan in virtual time, or without faults of lines"))]
    LineFault {
        /// Time of the fault, s.
        at_s: f64,
    },
    /// A device under test was switched off in real time: which of its inputs it still heard is not in the record.
    #[error(
        "a device under test was switched off in real time, at {at_s} s: what it still heard is not known"
    )]
    #[diagnostic(help("run the plan in virtual time"))]
    SwitchedOff {
        /// Time of the step, s.
        at_s: f64,
    },
    /// A fault held messages on a line of the device under test up: when its own got through also depends on those of other
    /// nodes, which do not send now.
    #[error(
        "a fault held messages on a line of the device under test up from {at_s} s on: when its own got through is not \
         comparable"
    )]
    #[diagnostic(help(
        "run the plan again without `babble`, `bus_load`, `lost_arbitration`, `bit_errors` and `delay` there, and without \
         `repeat`, `split` and `stall` of a serial line of several devices"
    ))]
    HeldUp {
        /// Time of the fault, s.
        at_s: f64,
    },
    /// A node sends on several lines.
    #[error("{who} speaks on several lines, and the record does not say on which")]
    #[diagnostic(help("a run of a rig without a gateway can be carried out again"))]
    SeveralLines { who: String },
    /// A device never rests.
    #[error("time stands still at {at_s} s: what is under test wants to be woken again and again")]
    #[diagnostic(help("a wake-up that was called is to lie in the future"))]
    StandsStill {
        /// Time, s.
        at_s: f64,
    },
}
