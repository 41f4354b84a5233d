//! Values that a file writes in one of several forms.

/// Implements `Deserialize` for a type that is written as a number or as a table, for example: what is expected, for
/// the message about anything else, and for each form the value of it, a `Result`. The forms are `number`, `finite` (a
/// finite number), `text`, `flag`, `list` and `map`; the last two are deserialisers of what they contain.
///
/// ```
/// # #[derive(Debug, PartialEq)]
/// enum Gap {
///     Metres(f64),
///     Named(String),
/// }
/// wire::either! { Gap, "a length or its name",
///     finite(metres) => Ok(Gap::Metres(metres)),
///     text(name) => Ok(Gap::Named(name.to_owned())),
/// }
/// # use serde::{Deserialize, de::{IntoDeserializer, value::Error}};
/// # let gap: Result<_, Error> = Gap::deserialize(2.into_deserializer());
/// # assert_eq!(gap, Ok(Gap::Metres(2.0)));
/// # let not: Result<Gap, Error> = Gap::deserialize(f64::NAN.into_deserializer());
/// # assert!(not.unwrap_err().to_string().ends_with("expected a length or its name"));
/// # let gap: Result<_, Error> = Gap::deserialize("wide".into_deserializer());
/// # assert_eq!(gap, Ok(Gap::Named("wide".to_owned())));
/// ```
#[macro_export]
macro_rules! either {
    (@number $of:ty, $_:expr, $value:pat_param => $made:expr) => {
        $crate::either! { @visit visit_f64(f64) $of, $value => $made }

        fn visit_i64<E: ::serde::de::Error>(self, whole: i64) -> Result<$of, E> {
            self.visit_f64(whole as f64)
        }

        fn visit_u64<E: ::serde::de::Error>(self, whole: u64) -> Result<$of, E> {
            self.visit_f64(whole as f64)
        }
    };
    (@finite $of:ty, $expected:expr, $value:pat_param => $made:expr) => {
        $crate::either! { @number $of, $expected, value => match value {
            $value if value.is_finite() => $made,
            _ => {
                let what = ::serde::de::Unexpected::Float(value);
                Err(::serde::de::Error::invalid_value(what, &$expected))
            }
        } }
    };
    (@text $of:ty, $_:expr, $value:pat_param => $made:expr) => {
        $crate::either! { @visit visit_str(&str) $of, $value => $made }
    };
    (@flag $of:ty, $_:expr, $value:pat_param => $made:expr) => {
        $crate::either! { @visit visit_bool(bool) $of, $value => $made }
    };
    (@list $of:ty, $_:expr, $value:pat_param => $made:expr) => {
        fn visit_seq<A: ::serde::de::SeqAccess<'de>>(self, list: A) -> Result<$of, A::Error> {
            let $value = ::serde::de::value::SeqAccessDeserializer::new(list);
            $made
        }
    };
    (@map $of:ty, $_:expr, $value:pat_param => $made:expr) => {
        fn visit_map<A: ::serde::de::MapAccess<'de>>(self, map: A) -> Result<$of, A::Error> {
            let $value = ::serde::de::value::MapAccessDeserializer::new(map);
            $made
        }
    };
    (@visit $visit:ident($type:ty) $of:ty, $value:pat_param => $made:expr) => {
        fn $visit<E: ::serde::de::Error>(self, $value: $type) -> Result<$of, E> {
            $made
        }
    };
    ($of:ty, $expected:expr, $($form:ident($value:pat_param) => $made:expr,)+) => {
        impl<'de> ::serde::Deserialize<'de> for $of {
            fn deserialize<D: ::serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                struct Either;
                impl<'de> ::serde::de::Visitor<'de> for Either {
                    type Value = $of;

                    fn expecting(&self, f: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                        f.write_str($expected)
                    }

                    $($crate::either! { @$form $of, $expected, $value => $made })+
                }
                from.deserialize_any(Either)
            }
        }
    };
}
