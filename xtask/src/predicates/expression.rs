//! Expressions without division: sums, differences, products, minima, written as text.
//!
//! ```text
//! sum     = product (("+" | "-") product)*      from left to right
//! product = factor ("*" factor)*                from left to right
//! factor  = name | integer | "(" sum ")" | "min" "(" sum "," sum ")"
//! ```
//!
//! The order of evaluation is the tree: it is what the proofs are about and what the Rust code
//! computes, so nothing here simplifies or reorders.

/// A tree of operations on named values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Expression {
    /// A value with a name: a coordinate difference, a parameter, or an earlier step.
    Name(String),
    /// A small integer, exact in every arithmetic.
    Integer(u32),
    /// An operation on two values.
    Binary(Operation, Box<Expression>, Box<Expression>),
}

/// An operation on two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    Add,
    Sub,
    Mul,
    Min,
}

use Expression::{Binary, Integer, Name};

impl Expression {
    /// Reads the notation above.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut parser = Parser { text, rest: text.trim_start() };
        let expression = parser.sum()?;
        if parser.rest.is_empty() { Ok(expression) } else { parser.fail("an operator") }
    }

    /// Every name in it, in the order of the text, repetitions included.
    pub(crate) fn names(&self) -> Vec<&str> {
        match self {
            Name(name) => vec![name],
            Integer(_) => Vec::new(),
            Binary(_, a, b) => a.names().into_iter().chain(b.names()).collect(),
        }
    }

    /// Is `operation` done in it?
    pub(crate) fn uses(&self, operation: Operation) -> bool {
        match self {
            Name(_) | Integer(_) => false,
            Binary(found, a, b) => *found == operation || a.uses(operation) || b.uses(operation),
        }
    }

    /// As Rust: no more parentheses than the tree needs.
    pub(crate) fn rust(&self) -> String {
        self.rust_in(0)
    }

    /// As Rust inside an operation of precedence `outer`: 0 none, 1 left of a sum, 2 right of a
    /// difference or left of a product, 3 right of a product.
    fn rust_in(&self, outer: u8) -> String {
        let (inner, text) = match self {
            Name(name) => return name.clone(),
            Integer(value) => return format!("{value}.0"),
            Binary(Operation::Add, a, b) => (1, format!("{} + {}", a.rust_in(1), b.rust_in(2))),
            Binary(Operation::Sub, a, b) => (1, format!("{} - {}", a.rust_in(1), b.rust_in(2))),
            Binary(Operation::Mul, a, b) => (2, format!("{} * {}", a.rust_in(2), b.rust_in(3))),
            Binary(Operation::Min, a, b) => {
                return format!("smaller({}, {})", a.rust_in(0), b.rust_in(0));
            }
        };
        if inner < outer { format!("({text})") } else { text }
    }
}

struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
}

impl Parser<'_> {
    fn fail<T>(&self, wanted: &str) -> Result<T, String> {
        Err(format!("`{}`: {wanted} expected at `{}`", self.text, self.rest))
    }

    /// Takes `token` if it comes next.
    fn take(&mut self, token: char) -> bool {
        let after = self.rest.strip_prefix(token);
        if let Some(after) = after {
            self.rest = after.trim_start();
        }
        after.is_some()
    }

    fn expect(&mut self, token: char) -> Result<(), String> {
        if self.take(token) { Ok(()) } else { self.fail(&format!("`{token}`")) }
    }

    fn sum(&mut self) -> Result<Expression, String> {
        let mut left = self.product()?;
        // Each round takes a character of the text.
        loop {
            let operation = if self.take('+') {
                Operation::Add
            } else if self.take('-') {
                Operation::Sub
            } else {
                return Ok(left);
            };
            left = Binary(operation, Box::new(left), Box::new(self.product()?));
        }
    }

    fn product(&mut self) -> Result<Expression, String> {
        let mut left = self.factor()?;
        while self.take('*') {
            left = Binary(Operation::Mul, Box::new(left), Box::new(self.factor()?));
        }
        Ok(left)
    }

    fn factor(&mut self) -> Result<Expression, String> {
        if self.take('(') {
            let inner = self.sum()?;
            self.expect(')')?;
            return Ok(inner);
        }
        let end = self.rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        let (word, after) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        if word.is_empty() {
            return self.fail("a value");
        }
        self.rest = after.trim_start();
        if word == "min" && self.take('(') {
            let left = self.sum()?;
            self.expect(',')?;
            let right = self.sum()?;
            self.expect(')')?;
            return Ok(Binary(Operation::Min, Box::new(left), Box::new(right)));
        }
        if word.starts_with(|c: char| c.is_ascii_digit()) {
            return word.parse().map(Integer).map_err(|error| format!("`{word}`: {error}"));
        }
        Ok(Name(word.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::Expression;

    #[test]
    fn text_is_read_from_left_to_right_and_written_as_it_was() {
        for text in [
            "a - b - c",
            "a - (b - c)",
            "a + (b + c)",
            "a * b * c",
            "a * (b * c)",
            "(a + b) * (c - d)",
            "smaller(a + b, c * d) * e",
            "2.0 * a",
        ] {
            let source = text.replace("smaller", "min").replace(".0", "");
            let found = Expression::parse(&source).expect("an expression");
            assert_eq!(found.rust(), text);
        }
        let product = Expression::parse("a*b-(c+min(a,d))").expect("an expression");
        assert_eq!(product.names(), ["a", "b", "c", "a", "d"]);
    }

    #[test]
    fn what_is_no_expression_is_refused() {
        for text in ["", "a +", "a b", "(a", "a)", "min(a)", "99999999999", "a / b"] {
            assert!(Expression::parse(text).is_err(), "{text}");
        }
    }
}
