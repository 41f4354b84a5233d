//! stub
pub mod least_squares;
