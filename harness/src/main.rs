//! stub
use std::collections::BTreeMap;
fn main() {
    let mut made = BTreeMap::new();
    for plan in std::env::args().skip(1) {
        let t = std::time::Instant::now();
        match harness::run::Prepared::load(&plan, &made) {
            Err(e) => println!("{:?}", miette::Report::new(e)),
            Ok(prepared) => {
                let out = format!("/tmp/runs/{plan}");
                let options = harness::run::Options {
                    seed: 1,
                    out: std::path::Path::new(&out),
                    level: Default::default(),
                    answers: BTreeMap::new(),
                };
                match harness::run::run_to_folder(&prepared, &options, &mut |_| true, &mut || {
                    t.elapsed().as_secs_f64()
                }) {
                    Err(e) => println!("{e}"),
                    Ok((summary, m)) => {
                        made.extend(m);
                        println!(
                            "{} {:?} {:?} sim {:.0} wall {:.2} x{:.0} events {}",
                            plan,
                            summary.outcome,
                            summary.reason,
                            summary.simulated_s,
                            summary.wall_s,
                            summary.simulated_s / summary.wall_s,
                            summary.events
                        );
                        print!(
                            "{}",
                            harness::console::measurements_table(
                                &[summary],
                                harness::console::Style::PLAIN
                            )
                        );
                    }
                }
            }
        }
    }
}
