//! The vocabulary of faults, one entry per kind. `docs/faults.md` has it as a table.

use super::Reach::{CanBus, Line, Message, Only, Powered, SerialLine};
use super::Share::{Checksum, Counter, Signal, Whole};
use super::declare::kinds;
use crate::faults::Target::{Base, Gyro, Host, Operator, Table};

/// The switches that kinds are positions of.
const LINE: Option<&str> = Some("line");
const READING: Option<&str> = Some("reading");
const TEMPERATURE: Option<&str> = Some("temperature");
const VELOCITY: Option<&str> = Some("velocity");
const ERRORS: Option<&str> = Some("bit errors");
const COUNTER: Option<&str> = Some("counter");
const VALUE: Option<&str> = Some("value");

kinds! {
    /// Each byte (on a bus, each frame) is lost with this probability.
    Drop = "drop", Line, Scheduled, None, "tc-netem(8), loss random" {
        /// Probability of a loss.
        loss_percent: "%" 0.0..=100.0, 1.0;
    }
    /// Bytes or frames are lost in bursts: a Gilbert-Elliott model of two states, each with a probability of loss and
    /// a probability of changing to the other, stepped once per byte or frame.
    BurstLoss = "burst_loss", Line, Scheduled, None, "tc-netem(8), loss gemodel p r 1-h 1-k" {
        /// Probability of going from the good to the bad state (p).
        loss_percent: "%" 0.0..=100.0, 1.0;
        /// Probability of going back (r).
        recover_percent: "%" 0.0..=100.0, 10.0;
        /// Probability of a loss in the bad state (1-h).
        bad_percent: "%" 0.0..=100.0, 100.0;
        /// Probability of a loss in the good state (1-k).
        good_percent: "%" 0.0..=100.0, 0.0;
    }
    /// Each byte or frame is duplicated with this probability.
    Duplicate = "duplicate", Line, Scheduled, None, "tc-netem(8), duplicate; ISO 11898-1, last bit of the end of frame" {
        /// Probability of a second one.
        duplicate_percent: "%" 0.0..=100.0, 1.0;
    }
    /// The plug is pulled: nothing gets through until it is back in.
    Disconnect = "disconnect", Line, Itself, LINE, "a plug" {
        /// How long it is out.
        for_s: "s" 0.001..=3600.0, 1.0;
    }
    /// Bytes are held back and then arrive all at once: a converter that buffers, or a host that does not read.
    Stall = "stall", SerialLine, Itself, LINE, "latency timer and buffers of USB converters" {
        /// How long they are held.
        for_s: "s" 0.001..=3600.0, 0.1;
    }
    /// One of the eight bits of a byte is inverted with this probability. These lines have no parity bit.
    Flip = "flip", SerialLine, Scheduled, None, "tc-netem(8), corrupt" {
        /// Probability that a byte is changed.
        flip_percent: "%" 0.0..=100.0, 0.1;
    }
    /// A spurious byte is inserted before a byte with this probability.
    Insert = "insert", SerialLine, Scheduled, None, "noise that looks like a start bit" {
        /// Probability of a spurious byte.
        insert_percent: "%" 0.0..=100.0, 0.1;
    }
    /// The sender's clock is fast (slow if negative): bits are sampled off their middle, and bytes whose stop bit is
    /// read as 0 are lost.
    BaudDrift = "baud_drift", SerialLine, Scheduled, None, "UART: one sample a bit, from the edge of the start bit on" {
        /// How fast.
        drift_percent: "%" -20.0..=20.0, 6.0;
    }
    /// With this probability, the receiver takes a bit within the first byte of a packet for the start bit, and reads
    /// on from there.
    FramingSlip = "framing_slip", SerialLine, Scheduled, None, "UART: any 1-to-0 edge can start a byte" {
        /// Probability that a packet is misread.
        slip_percent: "%" 0.0..=100.0, 1.0;
    }
    /// A packet is delivered a second time, directly after the first, with this probability.
    Repeat = "repeat", SerialLine, Scheduled, None, "assumption: a driver or a forwarder that sends a buffer again" {
        /// Probability of a second one.
        repeat_percent: "%" 0.0..=100.0, 1.0;
    }
    /// With this probability, a packet arrives in two parts, cut anywhere; the second part comes late by this time. A
    /// receiver that takes what one read returns for a whole message fails.
    Split = "split", SerialLine, Scheduled, None, "trigger level of a UART's FIFO; latency timer of USB converters (FTDI: 1 to 255 ms, 16 ms by default)" {
        /// Probability of a cut.
        split_percent: "%" 0.0..=100.0, 10.0;
        /// By how much the second part is late.
        late_s: "s" 0.0..=1.0, 0.016;
    }
    /// Each frame is delayed by this time.
    Delay = "delay", CanBus, Scheduled, None, "tc-netem(8), delay" {
        /// By how much.
        by_s: "s" 0.0..=10.0, 0.02;
    }
    /// With this probability, a frame waits for the next frame from the same node and is sent after it.
    Reorder = "reorder", CanBus, Scheduled, None, "tc-netem(8), reorder; drivers with several mailboxes" {
        /// Probability of waiting.
        reorder_percent: "%" 0.0..=100.0, 1.0;
    }
    /// One bit of the data is inverted with this probability, and the CRC does not detect it: the error happened in
    /// the memory of a CAN controller or in a gateway.
    Corrupt = "corrupt", CanBus, Scheduled, None, "tc-netem(8), corrupt; past the CRC of ISO 11898-1" {
        /// Probability that a frame is changed.
        corrupt_percent: "%" 0.0..=100.0, 0.1;
    }
    /// Another node floods the bus, with the identifier that wins every arbitration.
    Babble = "babble", CanBus, Scheduled, None, "babbling idiot: Kopetz; identifier 0 wins, ISO 11898-1" {
        /// Frames of eight bytes that the node tries to send.
        frames_per_s: "1/s" 1.0..=10000.0, 3000.0;
    }
    /// Other nodes exchange frames of all lengths, with identifiers of all kinds but those of the rig's messages.
    BusLoad = "bus_load", CanBus, Scheduled, None, "any shared bus" {
        /// Share of the bus that they would use if they had it to themselves.
        load_percent: "%" 0.1..=100.0, 60.0;
    }
    /// Bits of frames are read wrongly. Each error causes an error frame, counts in the error counters of transmitter
    /// and receivers, and leads to a retransmission. A node is error-passive from 128 and bus-off from 256, and
    /// returns after 128 times 11 recessive bits.
    BitErrors = "bit_errors", CanBus, Scheduled, ERRORS, "ISO 11898-1, fault confinement" {
        /// Errors per bit of a frame.
        bit_error_rate: "1" 0.0000001..=0.1, 0.0001;
    }
    /// With this probability for each attempt, another node starts a frame with a higher-priority identifier at the
    /// same bit.
    LostArbitration = "lost_arbitration", CanBus, Scheduled, None, "ISO 11898-1, arbitration" {
        /// Probability that an attempt is lost.
        lose_percent: "%" 0.0..=99.0, 50.0;
    }
    /// A message is sent with the same content every time, counter and checksum included.
    FrozenMessage = "frozen_message", Message(Whole), Itself, None, "ISO 26262-5 annex D: unintended message repetition" {
        /// How long.
        for_s: "s" 0.001..=3600.0, 1.0;
    }
    /// The counter of a message stands still; its checksum is correct.
    StuckCounter = "stuck_counter", Message(Counter), Itself, COUNTER, "ISO 26262-5 annex D: unintended message repetition" {
        /// How long.
        for_s: "s" 0.001..=3600.0, 1.0;
    }
    /// The counter of a message is ahead, as if messages had been lost; its checksum is correct.
    CounterJump = "counter_jump", Message(Counter), Scheduled, COUNTER, "ISO 26262-5 annex D: message loss" {
        /// By how many counts; the counter wraps.
        ahead: "1" 1.0..=65535.0, 2.0;
    }
    /// With this probability, every bit of a message's checksum is inverted.
    WrongChecksum = "wrong_checksum", Message(Checksum), Scheduled, None, "ISO 26262-5 annex D: message corruption" {
        /// Probability for each message.
        wrong_percent: "%" 0.0..=100.0, 100.0;
    }
    /// A signal keeps its value; counter, checksum and everything else continue.
    StuckSignal = "stuck_signal", Message(Signal), Itself, VALUE, "ISO 26262-5 annex D: sensor stuck in range" {
        /// How long.
        for_s: "s" 0.001..=3600.0, 1.0;
    }
    /// A signal is offset by a share of its declared range, as far as its bits can represent it; the checksum is
    /// correct.
    SignalOffset = "signal_offset", Message(Signal), Scheduled, VALUE, "ISO 26262-5 annex D: sensor offset" {
        /// Share of the range.
        range_percent: "%" -100.0..=100.0, 10.0;
    }
    /// A signal has this value, or the nearest that its bits can represent; the checksum is correct.
    SignalValue = "signal_value", Message(Signal), Scheduled, VALUE, "ISO 26262-5 annex D: sensor out of range" {
        /// The value, in the signal's unit.
        value: "1" -1000000000000.0..=1000000000000.0, 0.0;
    }
    /// The gyro keeps sending its last reading, marked valid.
    Stuck = "stuck", Only(Gyro), Itself, READING, "assumption: an output register that nobody fills" {
        /// How long.
        for_s: "s" 0.001..=3600.0, 1.0;
    }
    /// The gyro's range shrinks. Beyond it, the gyro reports the limit of the range, marked valid.
    OverRange = "over_range", Only(Gyro), Scheduled, None, "the paper's gyro keeps the valid bit beyond its range" {
        /// Share of the range that is gone.
        lost_percent: "%" 0.0..=100.0, 95.0;
    }
    /// The bias changes by this amount.
    BiasStep = "bias_step", Only(Gyro), Scheduled, None, "IEEE Std 952, bias shift" {
        /// By how much.
        deg_per_h: "deg/h" -36000.0..=36000.0, 60.0;
    }
    /// White noise is added to each reading.
    NoiseBurst = "noise_burst", Only(Gyro), Scheduled, None, "assumption: interference on the detector" {
        /// Its standard deviation.
        rms_deg_per_s: "deg/s" 0.0..=100.0, 1.0;
    }
    /// The temperature sensor keeps reporting the same value.
    TemperatureFrozen = "temperature_frozen", Only(Gyro), Itself, TEMPERATURE, "assumption: a sensor that hangs" {
        /// How long.
        for_s: "s" 0.001..=86400.0, 600.0;
    }
    /// The temperature sensor reports nonsense: noise of this size is added to it.
    TemperatureWild = "temperature_wild", Only(Gyro), Scheduled, TEMPERATURE, "assumption: a broken wire" {
        /// Its standard deviation.
        rms_kelvin: "K" 0.0..=200.0, 20.0;
    }
    /// The supply of a device fails, and the device starts anew: it neither sends nor receives for a time, and then has
    /// its start values (the gyro's counters and integrated angle are zero). A program is killed, and started again.
    Restart = "restart", Powered, Itself, READING, "brown-out" {
        /// How long it is off.
        for_s: "s" 0.001..=600.0, 1.0;
    }
    /// The base refuses velocity commands, and accepts all others.
    RefuseCommands = "refuse_commands", Only(Base), Itself, VELOCITY, "assumption: a drive that is not enabled" {
        /// How long.
        for_s: "s" 0.001..=3600.0, 0.5;
    }
    /// The base moves, but keeps reporting the same displacement, heading and pose.
    StuckOdometry = "stuck_odometry", Only(Base), Itself, None, "assumption: an encoder that lost its supply" {
        /// How long.
        for_s: "s" 0.001..=3600.0, 0.5;
    }
    /// The steering encoder counts an angle that was not turned.
    EncoderJump = "encoder_jump", Only(Base), Instant, None, "assumption: counts by interference" {
        /// How much, counter-clockwise.
        angle_deg: "deg" -360.0..=360.0, 5.0;
    }
    /// The wheels slip: the base travels less far than its odometer counts.
    WheelSlip = "wheel_slip", Only(Base), Scheduled, None, "Borenstein and Feng 1996, non-systematic errors" {
        /// Share of the distance that is lost.
        slip_percent: "%" 0.0..=100.0, 10.0;
    }
    /// The base executes a stop, or a velocity of zero, late.
    LateStop = "late_stop", Only(Base), Scheduled, VELOCITY, "assumption: a drive with a slow brake" {
        /// By how much.
        late_s: "s" 0.0..=10.0, 0.3;
    }
    /// The emergency stop is pressed, and released after this time.
    EmergencyStop = "emergency_stop", Only(Base), Itself, VELOCITY, "ISO 13850" {
        /// How long it is pressed.
        for_s: "s" 0.001..=3600.0, 1.0;
    }
    /// The table's motor loses steps, in whole electrical cycles of eight steps.
    LostSteps = "lost_steps", Only(Table), Instant, None, "stepper: a rotor locks in a whole cycle later" {
        /// How many, against the direction of rotation.
        steps: "1" 8.0..=28800.0, 80.0;
    }
    /// The controller or program under test is not scheduled: it receives nothing and is not woken, and then
    /// everything arrives at once.
    SchedulerStall = "scheduler_stall", Only(Host), Itself, None, "preemption, paging, a frozen virtual machine" {
        /// How long.
        for_s: "s" 0.001..=60.0, 0.1;
    }
    /// The clock of the controller or program under test jumps, and jumps back at the end. Of a program that is a node,
    /// this is the wall clock (`CLOCK_REALTIME`) alone, and what waits for a time of it; a controller and Rust code of a
    /// test have a single clock, which their waits follow too.
    ClockStep = "clock_step", Only(Host), Scheduled, None, "clock_settime(2), settimeofday(2)" {
        /// How far, forward.
        step_s: "s" -3600.0..=3600.0, 1.0;
    }
    /// The operator answers in the wrong unit: the number is too large by this factor.
    WrongUnit = "wrong_unit", Only(Operator), Scheduled, None, "millimetres for metres, degrees for radians" {
        /// The factor.
        factor: "1" 0.000001..=1000000.0, 1000.0;
    }
    /// The operator's answer has the wrong sign, with this probability.
    WrongSign = "wrong_sign", Only(Operator), Scheduled, None, "a y axis that points the other way" {
        /// Probability of it.
        wrong_percent: "%" 0.0..=100.0, 100.0;
    }
}
