//! Small arrays, entry by entry.

/// What the standard `map` of arrays gives, by code that stands in its caller.
///
/// The standard one is no inline function: where a crate is built in several units, as for tests, it is compiled in
/// another one than its caller, and inner loops took two and a half times as long for it.
pub(crate) trait MapEach<T> {
    /// The array of results.
    type Results<U>;

    /// What `of` gives for every entry, in their order.
    fn map_each<U>(self, of: impl FnMut(T) -> U) -> Self::Results<U>;
}

macro_rules! map_each {
    ($length:literal: $($entry:ident)+) => {
        impl<T> MapEach<T> for [T; $length] {
            type Results<U> = [U; $length];

            #[inline(always)]
            fn map_each<U>(self, mut of: impl FnMut(T) -> U) -> [U; $length] {
                let [$($entry),+] = self;
                [$(of($entry)),+]
            }
        }
    };
}

map_each!(2: a b);
map_each!(3: a b c);
map_each!(4: a b c d);
map_each!(6: a b c d e f);
map_each!(8: a b c d e f g h);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_taken_in_their_order() {
        let mut taken = Vec::new();
        let twice = [1, 2, 3, 4].map_each(|number| {
            taken.push(number);
            2 * number
        });
        assert_eq!((twice, taken), ([2, 4, 6, 8], vec![1, 2, 3, 4]));
    }
}
