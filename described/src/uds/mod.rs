//! UDS (ISO 14229-1:2020) on CAN: a server as a part of a described device, and a client for plans.

mod client;
mod diagnosis;
mod key;
mod monitor;
mod number;
#[cfg(test)]
mod tests;

pub use client::{Reply, Request, UdsClient};
pub(crate) use diagnosis::{
    Access, Content, Diagnosis, Did, Dtc, Field, Routine, Security, Service,
};
pub(crate) use key::KEY_BYTES_MAX;
pub use key::KeyFunction;
pub(crate) use monitor::{Monitor, WARNING};
pub use number::{Number, NumberType};

/// Services by the names in files.
pub(crate) const SERVICES: [(&str, u8); 11] = [
    ("session_control", sid::SESSION_CONTROL),
    ("ecu_reset", sid::ECU_RESET),
    ("clear_dtc", sid::CLEAR_DTC),
    ("read_dtc", sid::READ_DTC),
    ("read_data", sid::READ_DATA),
    ("security_access", sid::SECURITY_ACCESS),
    ("communication_control", sid::COMMUNICATION_CONTROL),
    ("write_data", sid::WRITE_DATA),
    ("routine_control", sid::ROUTINE_CONTROL),
    ("tester_present", sid::TESTER_PRESENT),
    ("control_dtc_setting", sid::CONTROL_DTC_SETTING),
];

pub(crate) mod sid {
    pub(crate) const SESSION_CONTROL: u8 = 0x10;
    pub(crate) const ECU_RESET: u8 = 0x11;
    pub(crate) const CLEAR_DTC: u8 = 0x14;
    pub(crate) const READ_DTC: u8 = 0x19;
    pub(crate) const READ_DATA: u8 = 0x22;
    pub(crate) const SECURITY_ACCESS: u8 = 0x27;
    pub(crate) const COMMUNICATION_CONTROL: u8 = 0x28;
    pub(crate) const WRITE_DATA: u8 = 0x2E;
    pub(crate) const ROUTINE_CONTROL: u8 = 0x31;
    pub(crate) const TESTER_PRESENT: u8 = 0x3E;
    pub(crate) const CONTROL_DTC_SETTING: u8 = 0x85;
    pub(crate) const NEGATIVE: u8 = 0x7F;
    /// Added to the identifier of a request in a positive response.
    pub(crate) const POSITIVE: u8 = 0x40;
}

/// Negative response codes (annex A).
pub(crate) mod nrc {
    pub(crate) const SERVICE_NOT_SUPPORTED: u8 = 0x11;
    pub(crate) const SUB_FUNCTION_NOT_SUPPORTED: u8 = 0x12;
    pub(crate) const INCORRECT_LENGTH: u8 = 0x13;
    pub(crate) const RESPONSE_TOO_LONG: u8 = 0x14;
    pub(crate) const BUSY_REPEAT_REQUEST: u8 = 0x21;
    pub(crate) const CONDITIONS_NOT_CORRECT: u8 = 0x22;
    pub(crate) const REQUEST_SEQUENCE_ERROR: u8 = 0x24;
    pub(crate) const REQUEST_OUT_OF_RANGE: u8 = 0x31;
    pub(crate) const SECURITY_ACCESS_DENIED: u8 = 0x33;
    pub(crate) const INVALID_KEY: u8 = 0x35;
    pub(crate) const EXCEEDED_ATTEMPTS: u8 = 0x36;
    pub(crate) const TIME_DELAY_NOT_EXPIRED: u8 = 0x37;
    pub(crate) const RESPONSE_PENDING: u8 = 0x78;
    pub(crate) const SUB_FUNCTION_NOT_SUPPORTED_IN_SESSION: u8 = 0x7E;
    pub(crate) const SERVICE_NOT_SUPPORTED_IN_SESSION: u8 = 0x7F;
}

/// The name of a negative response code, as the standard writes it.
pub const fn negative_response(code: u8) -> &'static str {
    match code {
        0x10 => "generalReject",
        nrc::SERVICE_NOT_SUPPORTED => "serviceNotSupported",
        nrc::SUB_FUNCTION_NOT_SUPPORTED => "subFunctionNotSupported",
        nrc::INCORRECT_LENGTH => "incorrectMessageLengthOrInvalidFormat",
        nrc::RESPONSE_TOO_LONG => "responseTooLong",
        nrc::BUSY_REPEAT_REQUEST => "busyRepeatRequest",
        nrc::CONDITIONS_NOT_CORRECT => "conditionsNotCorrect",
        nrc::REQUEST_SEQUENCE_ERROR => "requestSequenceError",
        nrc::REQUEST_OUT_OF_RANGE => "requestOutOfRange",
        nrc::SECURITY_ACCESS_DENIED => "securityAccessDenied",
        nrc::INVALID_KEY => "invalidKey",
        nrc::EXCEEDED_ATTEMPTS => "exceedNumberOfAttempts",
        nrc::TIME_DELAY_NOT_EXPIRED => "requiredTimeDelayNotExpired",
        0x72 => "generalProgrammingFailure",
        nrc::RESPONSE_PENDING => "requestCorrectlyReceived-ResponsePending",
        nrc::SUB_FUNCTION_NOT_SUPPORTED_IN_SESSION => "subFunctionNotSupportedInActiveSession",
        nrc::SERVICE_NOT_SUPPORTED_IN_SESSION => "serviceNotSupportedInActiveSession",
        _ => "another negative response",
    }
}

pub(crate) const DEFAULT_SESSION: u8 = 1;
