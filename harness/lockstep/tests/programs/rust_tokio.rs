//! A controller in Rust with tokio on two threads: a serial port, a timer, a channel.

use std::time::Duration;
use tokio::io::{AsyncBufReadExt as _, AsyncWriteExt as _, BufReader};
use tokio_serial::SerialPortBuilderExt as _;

#[expect(clippy::disallowed_methods, reason = "it knows nothing of virtual time")]
fn main() {
    let words: Vec<String> = std::env::args().collect();
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    runtime.expect("a runtime").block_on(async {
        let gyro = tokio_serial::new(&words[1], 115_200).open_native_async().expect("the gyro");
        let mut base = tokio_serial::new(&words[2], 115_200).open_native_async().expect("the base");
        let (sender, mut samples) = tokio::sync::mpsc::channel(16);
        tokio::spawn(async move {
            let mut lines = BufReader::new(gyro).lines();
            while let Ok(Some(line)) = lines.next_line().await {
                sender.send(line.parse::<f64>().expect("a number")).await.expect("a listener");
            }
        });
        let start = tokio::time::Instant::now();
        let mut beat = tokio::time::interval(Duration::from_millis(25));
        let mut heading = 0.0;
        loop {
            tokio::select! {
                biased;
                Some(value) = samples.recv() => heading += value / 100.0,
                _ = beat.tick() => {
                    let text = format!("{heading:.4} {}\n", start.elapsed().as_nanos());
                    base.write_all(text.as_bytes()).await.expect("the base");
                }
            }
        }
    });
}
