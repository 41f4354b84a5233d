//! The line protocol of a stepper-driven rotary table.
//!
//! A documented subset in the manner of the ASCII indexers of the 1990s: a line is a letter, an
//! optional signed decimal number and CR; the answer is a line as well.
//!
//! | line | meaning | answer |
//! |---|---|---|
//! | `V2400` | top step rate, steps/s | `=V` |
//! | `A1200` | ramp, steps/s^2 | `=A` |
//! | `D-28800` | distance of the next move, steps; ccw is positive | `=D` |
//! | `G` | go | `=G`; `!G` while moving |
//! | `S` | stop with the ramp | `=S` |
//! | `?` | state | `=P<steps> M0` at rest, `=P<steps> M1` moving |
//! | anything else | | `!` and the line's first letter |
