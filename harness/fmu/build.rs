//! Builds the logger of FMI 2.0, which is in C.

fn main() {
    println!("cargo::rerun-if-changed=src/native/logger.c");
    cc::Build::new().file("src/native/logger.c").compile("hil_fmi2_logger");
}
