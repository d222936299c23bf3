//! Kinds of point sets and of domains as text, there and back (feature `serde`).
#![cfg(feature = "serde")]

use ltbw_generate::{DomainKind, PointKind};

#[test]
fn kinds_survive() {
    for kind in PointKind::ALL {
        let text = serde_json::to_string(&kind).expect("a name");
        assert_eq!(serde_json::from_str::<PointKind>(&text).expect("a kind"), kind);
    }
    for kind in DomainKind::ALL {
        let text = serde_json::to_string(&kind).expect("a name");
        assert_eq!(serde_json::from_str::<DomainKind>(&text).expect("a kind"), kind);
    }
}
