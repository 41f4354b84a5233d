//! stub
pub mod calibrations;
pub mod checks;
pub mod console;
pub mod engine;
pub mod figures;
pub mod junit;
pub mod library;
pub mod link;
pub mod observation;
pub mod outcome;
pub mod plan;
pub mod record;
pub mod report;
pub mod run;
pub mod run_folder;
pub mod world;
