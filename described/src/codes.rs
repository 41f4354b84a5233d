//! Codes of a standard with its words for them.

/// Declares constants, inside an `impl` of a type around the code or beside each other as numbers, and `text`, which
/// finds the words for a code. A code that needs no constant is `_`.
///
/// ```ignore
/// impl Abort {
///     codes! { pub Self(u32);
///         TOGGLE = 0x0503_0000, "toggle bit not alternated";
///         _ = 0x0504_0002, "invalid block size";
///     }
/// }
/// ```
macro_rules! codes {
    ($vis:vis Self($code:ident); $($name:tt = $number:literal, $text:literal;)+) => {
        $($crate::codes::codes! { @constant $vis, $name, Self, Self($number), $text })+
        $crate::codes::codes! { @text $code, $($number, $text;)+ }
    };
    ($vis:vis $code:ident; $($name:tt = $number:literal, $text:literal;)+) => {
        $($crate::codes::codes! { @constant $vis, $name, $code, $number, $text })+
        $crate::codes::codes! { @text $code, $($number, $text;)+ }
    };
    (@constant $vis:vis, _, $of:ty, $value:expr, $text:literal) => {};
    (@constant $vis:vis, $name:ident, $of:ty, $value:expr, $text:literal) => {
        #[doc = concat!("`", $text, "`.")]
        $vis const $name: $of = $value;
    };
    (@text $code:ident, $($number:literal, $text:literal;)+) => {
        /// The standard's words for a code; `None` for one that it does not list.
        pub(super) const fn text(code: $code) -> Option<&'static str> {
            Some(match code {
                $($number => $text,)+
                _ => return None,
            })
        }
    };
}

pub(crate) use codes;
