//! The canonical hash that a mesh file carries: `.vtu` in a comment, `.msh` in a section
//! `$Comments`. Other readers pass over both, and no program that changes the mesh copies them.
//! What is carried is said, not computed: [`ltbw_core::canonical_hash`] tells whether it is true.

use crate::Format;

/// The name of the hash, before its digits.
const NAME: &str = "ltbw.mesh/1 ";
/// Digits of the hash.
const DIGITS: usize = 64;
/// Bytes of a file in which the hash stands, if it carries one.
const HEAD: usize = 1024;

/// The line that carries a hash.
pub(crate) fn line(hash: &str) -> String {
    format!("{NAME}{hash}")
}

/// The hash that a file of this format carries, as 64 lower-case hexadecimal digits.
pub fn carried_hash(format: Format, bytes: &[u8]) -> Option<String> {
    let (before, after): (&[u8], &[u8]) = match format {
        Format::Vtu => (b"<!-- ", b" -->"),
        Format::Msh => (b"$Comments\n", b"\n$EndComments"),
        _ => return None,
    };
    let word = [before, NAME.as_bytes()].concat();
    let head = &bytes[..bytes.len().min(HEAD)];
    let at = head.windows(word.len()).position(|part| part == word)? + word.len();
    let digits = head.get(at..at + DIGITS).filter(|_| head[at + DIGITS..].starts_with(after))?;
    let is_digit = |c: &u8| matches!(c, b'0'..=b'9' | b'a'..=b'f');
    digits.iter().all(is_digit).then(|| String::from_utf8_lossy(digits).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hash_is_found_where_it_is_written_and_nowhere_else() {
        let hash = "0123456789abcdef".repeat(4);
        let comment = format!("<?xml version=\"1.0\"?>\n<!-- {} -->\n", line(&hash));
        let section = format!("$MeshFormat\n$Comments\n{}\n$EndComments\n", line(&hash));
        assert_eq!(carried_hash(Format::Vtu, comment.as_bytes()), Some(hash.clone()));
        assert_eq!(carried_hash(Format::Msh, section.as_bytes()), Some(hash.clone()));
        for (format, text) in [
            (Format::Msh, comment.clone()),
            (Format::Vtu, section),
            (Format::Medit, comment.clone()),
            (Format::Vtu, comment.replace('f', "g")),
            (Format::Vtu, comment.replace(" -->", "0 -->")),
            (Format::Vtu, comment[..80].to_owned()),
            (Format::Vtu, String::new()),
        ] {
            assert_eq!(carried_hash(format, text.as_bytes()), None, "{text}");
        }
    }
}
