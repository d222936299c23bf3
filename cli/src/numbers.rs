//! Whole numbers of the command line: all options that take one take it in the same ways.

use std::ops::RangeInclusive;

/// A number above which not every whole number is a double.
const EXACT: f64 = 9_007_199_254_740_992.0;
/// Limits up to which numbers are short enough to be written out.
const SHORT: u64 = 100_000;

/// A parser of whole numbers in a range, also written like `1e6`.
pub(crate) fn whole<T: TryFrom<u64> + Clone + Send + Sync + 'static>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        let value = value(text).filter(|value| range.contains(value));
        value.and_then(|value| T::try_from(value).ok()).ok_or_else(|| wanted(&range))
    }
}

/// The whole number that a text means.
fn value(text: &str) -> Option<u64> {
    let scientific = || {
        let value: f64 = text.parse().ok()?;
        ((0.0..=EXACT).contains(&value) && value.fract() == 0.0).then_some(value as u64)
    };
    text.parse().ok().or_else(scientific)
}

/// The numbers that are wanted, in words.
fn wanted(range: &RangeInclusive<u64>) -> String {
    let (least, most) = (range.start(), range.end());
    let limits = match (*least, *most) {
        (0, u64::MAX) => String::new(),
        (_, u64::MAX) => format!(" of at least {least}"),
        _ => format!(" from {least} to {most}"),
    };
    let example = if *most > SHORT { ", such as 20000 or 2e4" } else { "" };
    format!("expected a whole number{limits}{example}")
}

#[cfg(test)]
mod tests {
    use super::whole;

    #[test]
    fn whole_numbers_are_written_in_several_ways() {
        let any = whole::<u64>(0..=u64::MAX);
        let big = u64::MAX.to_string();
        let good = [("1000", 1000), ("1e3", 1000), ("2.5e1", 25), ("3.0", 3), (&big, u64::MAX)];
        for (text, value) in good {
            assert_eq!(any(text), Ok(value), "{text}");
        }
        let wanted = "expected a whole number, such as 20000 or 2e4";
        for text in ["", "x", "-5", "1.5", "1e30", "NaN", "inf", "1e-3", "2 "] {
            assert_eq!(any(text), Err(wanted.to_owned()), "{text}");
        }
    }

    #[test]
    fn limits_are_told() {
        let threads = whole::<u16>(1..=1024);
        assert_eq!(threads("2e0"), Ok(2));
        for text in ["0", "1025", "-1", "1e5", "two"] {
            let wanted = "expected a whole number from 1 to 1024".to_owned();
            assert_eq!(threads(text), Err(wanted), "{text}");
        }
        let told = whole::<u32>(4..=u64::MAX)("3").unwrap_err();
        assert_eq!(told, "expected a whole number of at least 4, such as 20000 or 2e4");
        // No type holds more than it can.
        assert!(whole::<u8>(0..=u64::MAX)("256").is_err());
    }
}
