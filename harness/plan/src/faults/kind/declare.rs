//! Generates the type of the vocabulary, its notation in a plan, and its table from one declaration.

/// Declares the kinds of faults. Every kind has a key, a reach, a rule for its end, the switch that it is a position
/// of, and a source; every parameter has a unit, a range and a typical value. The first parameter is the severity.
macro_rules! kinds {
    ($(
        $(#[doc = $doc:literal])+
        $kind:ident = $name:literal, $reach:expr, $lasts:ident, $switch:expr, $source:literal {
            $($(#[doc = $parameter_doc:literal])+
            $parameter:ident: $unit:literal $least:literal..=$greatest:literal, $typical:literal;)+
        }
    )*) => {
        /// A kind of fault. In a plan it is a table with one key, the kind, and the parameters below it; the names
        /// of the parameters carry their units.
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "snake_case", deny_unknown_fields)]
        pub enum FaultKind {
            $($(#[doc = $doc])+ $kind {
                $($(#[doc = $parameter_doc])+ $parameter: f64,)+
            },)*
        }

        impl FaultKind {
            /// All kinds.
            pub const fn all() -> &'static [$crate::faults::KindInfo] {
                const ALL: &[$crate::faults::KindInfo] = &[$($crate::faults::KindInfo {
                    name: $name,
                    doc: concat!($($doc),+),
                    parameters: &[$($crate::faults::KindParameter {
                        name: stringify!($parameter),
                        doc: concat!($($parameter_doc),+),
                        unit: $unit,
                        range: ($least, $greatest),
                    },)+],
                    reach: $reach,
                    lasts: $crate::faults::Lasts::$lasts,
                    switch: $switch,
                    source: $source,
                    typical: FaultKind::$kind { $($parameter: $typical,)+ },
                },)*];
                ALL
            }

            /// Index in [`Self::all`].
            pub(super) fn index(&self) -> usize {
                #[derive(Clone, Copy)]
                enum Index { $($kind,)* }
                (match self { $(Self::$kind { .. } => Index::$kind,)* }) as usize
            }

            /// The values of its parameters, in order.
            pub fn values(&self) -> Vec<f64> {
                match *self {
                    $(Self::$kind { $($parameter,)+ } => vec![$($parameter,)+],)*
                }
            }

            /// The same kind with another value of the parameter at `place`.
            #[must_use]
            pub fn with_value(mut self, place: usize, value: f64) -> Self {
                let parameters: Vec<&mut f64> = match &mut self {
                    $(Self::$kind { $($parameter,)+ } => vec![$($parameter,)+],)*
                };
                if let Some(parameter) = parameters.into_iter().nth(place) {
                    *parameter = value;
                }
                self
            }
        }
    };
}

pub(super) use kinds;
