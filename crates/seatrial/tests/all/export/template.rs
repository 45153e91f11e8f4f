//! Text templates.

use seatrial::export::fill;

#[test]
fn what_is_filled_in_is_not_looked_at_again() {
    let values = [("a", "{{b}}".to_owned()), ("b", "2".to_owned())];
    assert_eq!(fill("<{{a}} {{b}}>", &values), "<{{b}} 2>");
}
