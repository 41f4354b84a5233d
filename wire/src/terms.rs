//! Terms of an identified gyro model, as files and missions write them.

/// Declares `Term`, `Acts`, `Form` and `Point` with these attributes, around a `Driver` of the module and a list of the
/// points of a table. Each side has inputs, evaluations and room of its own: what is true of a gyro, and what its
/// controller knows of that.
///
/// ```ignore
/// wire::terms! {
///     #[derive(JsonSchema)]
///     points: Vec<Point>
/// }
/// ```
#[macro_export]
macro_rules! terms {
    ($(#[$attribute:meta])* points: $points:ty) => {
        /// One term.
        #[derive(Debug, Clone, PartialEq, ::serde::Deserialize)]
        $(#[$attribute])*
        #[serde(deny_unknown_fields)]
        pub struct Term {
            /// What it acts on.
            pub acts: Acts,
            /// Its input; none for a constant.
            #[serde(default)]
            pub driver: Driver,
            /// How it depends on its input.
            pub form: Form,
            /// Range of its input: beyond it, the term is constant.
            #[serde(default)]
            pub within: Option<[f64; 2]>,
            /// The same of a product's second input.
            #[serde(default)]
            pub within_2: Option<[f64; 2]>,
        }

        impl ::serde::Serialize for Term {
            /// Text formats omit a range that is not given; formats read by position include it.
            fn serialize<S: ::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                use ::serde::ser::SerializeStruct as _;
                let is_text = serializer.is_human_readable();
                let ranges = [("within", &self.within), ("within_2", &self.within_2)];
                let ranges = ranges.iter().filter(|(_, range)| !is_text || range.is_some());
                let mut term = serializer.serialize_struct("Term", 3 + ranges.clone().count())?;
                term.serialize_field("acts", &self.acts)?;
                term.serialize_field("driver", &self.driver)?;
                term.serialize_field("form", &self.form)?;
                for (name, range) in ranges {
                    term.serialize_field(name, range)?;
                }
                term.end()
            }
        }

        /// What a term acts on.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, ::serde::Serialize, ::serde::Deserialize)]
        $(#[$attribute])*
        #[serde(rename_all = "snake_case")]
        pub enum Acts {
            /// Added to the rate, rad/s.
            Bias,
            /// Added to the scale.
            Scale,
        }

        /// How a term depends on its driver x.
        #[derive(Debug, Clone, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        $(#[$attribute])*
        #[serde(rename_all = "snake_case", deny_unknown_fields)]
        #[expect(missing_docs, reason = "each variant's formula names its fields")]
        pub enum Form {
            /// `value`.
            Constant { value: f64 },
            /// `slope (x - origin)`.
            Linear { slope: f64, origin: f64 },
            /// `coefficient (x - origin)^2`.
            Quadratic { coefficient: f64, origin: f64 },
            /// `coefficient (x - origin)^3`.
            Cubic { coefficient: f64, origin: f64 },
            /// `amplitude exp(-x / time_constant)`.
            Exponential { amplitude: f64, time_constant: f64 },
            /// `cos` cos(order x) + `sin` sin(order x), for an angle.
            Harmonic { order: u8, cos: f64, sin: f64 },
            /// `cos` cos(2 pi x / period) + `sin` sin(2 pi x / period).
            Periodic { cos: f64, sin: f64, period: f64 },
            /// `size` from `at` on.
            Step { size: f64, at: f64 },
            /// `slope max(0, x - at)`.
            Hinge { slope: f64, at: f64 },
            /// `height exp(-((x - centre) / width)^2 / 2)`.
            Bump { height: f64, centre: f64, width: f64 },
            /// `height tanh((x - centre) / width)`.
            Tanh { height: f64, centre: f64, width: f64 },
            /// Linear between points, constant beyond them.
            Table { points: $points },
            /// `coefficient (x - origin) (y - origin_2)`, y of the second driver.
            Product { coefficient: f64, origin: f64, second: Driver, origin_2: f64 },
        }

        impl Form {
            /// The second driver of a product; `Driver::None` otherwise.
            const fn second(&self) -> Driver {
                match self {
                    Self::Product { second, .. } => *second,
                    _ => Driver::None,
                }
            }
        }

        /// A point of a table.
        #[derive(Debug, Clone, Copy, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        $(#[$attribute])*
        #[serde(deny_unknown_fields)]
        pub struct Point {
            /// Where, in the driver's unit.
            pub x: f64,
            /// The term there.
            pub value: f64,
        }

        impl Term {
            /// Its value for these inputs.
            fn value(&self, x: f64, y: f64) -> f64 {
                let held = |value: f64, range: Option<[f64; 2]>| {
                    range.map_or(value, |[low, high]| value.max(low).min(high))
                };
                self.form.value(held(x, self.within), held(y, self.within_2))
            }
        }
    };
}
