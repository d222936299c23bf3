//! A canonical hash as it is stored, with the feature `serde`.
#![cfg(feature = "serde")]

use ltbw_core::{MeshHash, canonical_hash};
use ltbw_exact::Point;

const POINTS: [Point; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[test]
fn it_is_stored_as_its_text() {
    let hash = canonical_hash(&POINTS, &[[0, 1, 2, 3]]).expect("a hash");
    let text = format!("\"{hash}\"");
    assert_eq!(serde_json::to_string(&hash).expect("text"), text);
    assert_eq!(serde_json::from_str::<MeshHash>(&text).expect("a hash"), hash);
    let wrong = [&text[1..], &text[2..], &text.to_uppercase(), &text.replacen('2', "g", 1), "7"];
    for text in wrong {
        assert!(serde_json::from_str::<MeshHash>(text).is_err(), "{text}");
    }
    let refused = serde_json::from_str::<MeshHash>(&text.replacen('2', "G", 1));
    let message = refused.expect_err("not a digit").to_string();
    assert!(message.contains("is not 64 lower-case hexadecimal digits"), "{message}");
}
