//! UDS (ISO 14229-1:2020) on CAN: a server as a part of a described device, a client for plans, and a
//! listener for logs.

mod client;
mod diagnosis;
mod key;
mod listener;
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
pub use listener::UdsListener;
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

/// Negative response codes (annex A), with the names that the standard gives them.
pub(crate) mod nrc {
    crate::codes::codes! { pub(crate) u8;
        _ = 0x10, "generalReject";
        SERVICE_NOT_SUPPORTED = 0x11, "serviceNotSupported";
        SUB_FUNCTION_NOT_SUPPORTED = 0x12, "subFunctionNotSupported";
        INCORRECT_LENGTH = 0x13, "incorrectMessageLengthOrInvalidFormat";
        RESPONSE_TOO_LONG = 0x14, "responseTooLong";
        BUSY_REPEAT_REQUEST = 0x21, "busyRepeatRequest";
        CONDITIONS_NOT_CORRECT = 0x22, "conditionsNotCorrect";
        REQUEST_SEQUENCE_ERROR = 0x24, "requestSequenceError";
        REQUEST_OUT_OF_RANGE = 0x31, "requestOutOfRange";
        SECURITY_ACCESS_DENIED = 0x33, "securityAccessDenied";
        INVALID_KEY = 0x35, "invalidKey";
        EXCEEDED_ATTEMPTS = 0x36, "exceedNumberOfAttempts";
        TIME_DELAY_NOT_EXPIRED = 0x37, "requiredTimeDelayNotExpired";
        _ = 0x72, "generalProgrammingFailure";
        RESPONSE_PENDING = 0x78, "requestCorrectlyReceived-ResponsePending";
        SUB_FUNCTION_NOT_SUPPORTED_IN_SESSION = 0x7E, "subFunctionNotSupportedInActiveSession";
        SERVICE_NOT_SUPPORTED_IN_SESSION = 0x7F, "serviceNotSupportedInActiveSession";
    }
}

/// The name of a negative response code, as the standard writes it.
pub fn negative_response(code: u8) -> &'static str {
    nrc::text(code).unwrap_or("another negative response")
}

pub(crate) const DEFAULT_SESSION: u8 = 1;
