//! Enums with a table: what each variant stands for.

/// Declares an enum without data, with the name of each variant: `ALL`, `NAMES` and `name`.
#[macro_export]
macro_rules! words {
    ($(#[$attribute:meta])* $vis:vis enum $of:ident {
        $($(#[$of_variant:meta])* $variant:ident = $name:literal,)+
    }) => {
        $crate::tabled! {
            $(#[$attribute])*
            $vis enum $of {
                $($(#[$of_variant])* $variant = $name,)+
            }
            /// Its name.
            pub fn name() -> &'static str
        }

        impl $of {
            /// Their names.
            pub const NAMES: [&'static str; Self::ALL.len()] = [$($name),+];
        }
    };
}

/// Declares an enum without data, with `ALL` of its variants, and a function that returns the value of each.
#[macro_export]
macro_rules! tabled {
    ($(#[$attribute:meta])* $vis:vis enum $of:ident {
        $($(#[$of_variant:meta])* $variant:ident = $value:expr,)+
    }
    $(#[$of_value:meta])* $get_vis:vis fn $get:ident() -> $type:ty) => {
        $(#[$attribute])*
        $vis enum $of {
            $($(#[$of_variant])* $variant,)+
        }

        impl $of {
            /// All, in this order.
            pub const ALL: [Self; [$(stringify!($variant)),+].len()] = [$(Self::$variant),+];

            $(#[$of_value])*
            $get_vis const fn $get(self) -> $type {
                match self {
                    $(Self::$variant => $value,)+
                }
            }
        }
    };
}
