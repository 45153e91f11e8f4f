//! The part of the work of each shard.

use files::Shard;
use proptest::prelude::*;

#[test]
fn text_form_is_strict() {
    assert_eq!("2/4".parse(), Ok(Shard { index: 2, count: 4 }));
    for wrong in ["", "2", "0/4", "5/4", "+1/4", "01/4", "1/4/4", "a/b", "1/0", "-1/4", " 1/4"] {
        assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
    }
}

proptest! {
    #[test]
    fn law_ranges_partition_the_items(items in 0_usize..10_000, count in 1_u32..200) {
        let mut next = 0;
        for index in 1..=count {
            let range = Shard { index, count }.range(items);
            prop_assert_eq!(range.start, next);
            let length = range.len();
            prop_assert!(length == items / count as usize || length == items.div_ceil(count as usize));
            next = range.end;
        }
        prop_assert_eq!(next, items);
    }
}
