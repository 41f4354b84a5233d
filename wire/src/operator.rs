//! Operators of quantities.

/// Implements an operator, always inlined: of two operands with the type of the result, of one, or with assignment.
///
/// ```ignore
/// operator!(Add::add, Timestamp, Span => Timestamp, |a, b| Timestamp(sum(a.0, b.0)));
/// operator!(Neg::neg, Span => Span, |a| Span(a.0.saturating_neg()));
/// operator!(AddAssign::add_assign, Timestamp, Span, |a, b| a + b);
/// ```
macro_rules! operator {
    ($trait:ident::$call:ident, $left:ty, $right:ty => $out:ty, |$a:ident, $b:ident| $value:expr) => {
        impl core::ops::$trait<$right> for $left {
            type Output = $out;
            #[inline]
            fn $call(self, $b: $right) -> $out {
                let $a = self;
                $value
            }
        }
    };
    ($trait:ident::$call:ident, $of:ty => $out:ty, |$a:ident| $value:expr) => {
        impl core::ops::$trait for $of {
            type Output = $out;
            #[inline]
            fn $call(self) -> $out {
                let $a = self;
                $value
            }
        }
    };
    ($trait:ident::$call:ident, $left:ty, $right:ty, |$a:ident, $b:ident| $value:expr) => {
        impl core::ops::$trait<$right> for $left {
            #[inline]
            fn $call(&mut self, $b: $right) {
                let $a = *self;
                *self = $value;
            }
        }
    };
}

pub(crate) use operator;
