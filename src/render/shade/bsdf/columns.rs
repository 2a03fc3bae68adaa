//! Columns of numbers in which BSDF parameters are kept, one value for every vertex of a wave.

use std::ops::Range;

use petzval_base::lanes::Real;
use petzval_base::rays::SortedColumn;

/// A value that is kept in columns: a number, an array of such values, or a struct of the macro
/// [`columns!`].
pub(in crate::shade) trait Columns<R: Real<Scalar = f32>>: Copy {
    /// Number of columns.
    const COUNT: usize;

    /// Loads the packet that begins at an entry from the first columns.
    fn from_columns(columns: &[SortedColumn<f32>], at: usize) -> Self;

    /// Stores the packet that begins at an entry in the first columns.
    fn store_in(self, columns: &mut [SortedColumn<f32>], at: usize);

    /// Stores the packet in all entries of a range. The last packet may end behind the range.
    #[inline(always)]
    fn fill_in(self, columns: &mut [SortedColumn<f32>], range: Range<usize>) {
        for at in range.step_by(R::LANES) {
            self.store_in(columns, at);
        }
    }
}

impl<R: Real<Scalar = f32>> Columns<R> for R {
    const COUNT: usize = 1;

    #[inline(always)]
    fn from_columns(columns: &[SortedColumn<f32>], at: usize) -> Self {
        R::load(&columns[0][at..])
    }

    #[inline(always)]
    fn store_in(self, columns: &mut [SortedColumn<f32>], at: usize) {
        self.store(&mut columns[0][at..]);
    }
}

impl<R: Real<Scalar = f32>, const N: usize> Columns<R> for [R; N] {
    const COUNT: usize = N;

    #[inline(always)]
    fn from_columns(columns: &[SortedColumn<f32>], at: usize) -> Self {
        let mut values = [R::splat(0.0); N];
        for i in 0..N {
            values[i] = R::load(&columns[i][at..]);
        }
        values
    }

    #[inline(always)]
    fn store_in(self, columns: &mut [SortedColumn<f32>], at: usize) {
        for i in 0..N {
            self[i].store(&mut columns[i][at..]);
        }
    }
}

/// Defines a struct whose fields are kept in columns, in the order of the fields.
macro_rules! columns {
    (
        $(#[$about:meta])*
        $visibility:vis struct $name:ident<$R:ident> {
            $($(#[$about_field:meta])* $field_visibility:vis $field:ident: $type:ty,)+
        }
    ) => {
        $(#[$about])*
        $visibility struct $name<$R> {
            $($(#[$about_field])* $field_visibility $field: $type,)+
        }

        impl<$R: petzval_base::lanes::Real<Scalar = f32>> $crate::shade::bsdf::Columns<$R> for $name<$R> {
            const COUNT: usize = 0 $(+ <$type as $crate::shade::bsdf::Columns<$R>>::COUNT)+;

            #[inline(always)]
            fn from_columns(columns: &[petzval_base::rays::SortedColumn<f32>], at: usize) -> Self {
                let rest = columns;
                $(
                    let count = <$type as $crate::shade::bsdf::Columns<$R>>::COUNT;
                    let (own, rest) = rest.split_at(count);
                    let $field = <$type as $crate::shade::bsdf::Columns<$R>>::from_columns(own, at);
                )+
                let _ = rest;
                Self { $($field),+ }
            }

            #[inline(always)]
            fn store_in(self, columns: &mut [petzval_base::rays::SortedColumn<f32>], at: usize) {
                let rest = columns;
                $(
                    let count = <$type as $crate::shade::bsdf::Columns<$R>>::COUNT;
                    let (own, rest) = rest.split_at_mut(count);
                    $crate::shade::bsdf::Columns::<$R>::store_in(self.$field, own, at);
                )+
                let _ = rest;
            }
        }
    };
}
pub(in crate::shade) use columns;

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::lanes::f32x8;

    columns! {
        #[derive(Clone, Copy, Debug, PartialEq)]
        struct Inner<R> {
            pair: [R; 2],
            last: R,
        }
    }

    columns! {
        #[derive(Clone, Copy, Debug, PartialEq)]
        struct Outer<R> {
            first: R,
            inner: Inner<R>,
        }
    }

    const VALUES: Outer<f32> = Outer { first: 1.0, inner: Inner { pair: [2.0, 3.0], last: 4.0 } };

    #[test]
    fn fields_are_stored_in_their_order_and_loaded_again() {
        let mut columns = [SortedColumn::<f32>::default(); 5];
        assert_eq!(<Outer<f32> as Columns<f32>>::COUNT, 4);
        VALUES.store_in(&mut columns, 3);
        assert_eq!([0, 1, 2, 3, 4].map(|i| columns[i][3]), [1.0, 2.0, 3.0, 4.0, 0.0]);
        assert_eq!(<Outer<f32> as Columns<f32>>::from_columns(&columns, 3), VALUES);
    }

    #[test]
    fn packets_fill_all_entries_of_a_range_and_none_before_it() {
        let mut columns = [SortedColumn::<f32>::default(); 4];
        let splat = f32x8::splat;
        let inner = Inner { pair: [splat(2.0), splat(3.0)], last: splat(4.0) };
        Outer { first: splat(1.0), inner }.fill_in(&mut columns, 5..16);
        assert_eq!(<Outer<f32> as Columns<f32>>::from_columns(&columns, 4).first, 0.0);
        for at in 5..16 {
            assert_eq!(<Outer<f32> as Columns<f32>>::from_columns(&columns, at), VALUES);
        }
    }
}
