//! The text of a formula as a tree.
//!
//! From loosest to tightest: `+ -`, `* /`, a sign, `^` (to the right: `2^3^2` is 2⁹, and `-x^2` is −(x²)). A number may carry its
//! unit in brackets.

use winnow::combinator::{Infix, Prefix, cut_err, dispatch, expression, fail, not, opt, peek, separated};
use winnow::error::{ErrMode, ParserError};
use winnow::prelude::*;
use winnow::stream::{LocatingSlice, Location};
use winnow::token::{any, one_of, take_while};

use crate::error::{Error, Place};
use crate::unit::Unit;

/// The longest formula, in bytes: bounds the time it takes, and the depth of its tree.
const MOST_BYTES: usize = 500;
/// The deepest parentheses.
const MOST_NESTED: usize = 12;
/// The most powers.
const MOST_POWERS: usize = 24;

/// Part of a formula, with its place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Node {
    pub(crate) at: Place,
    pub(crate) kind: Kind,
}

/// What it is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kind {
    Number(f64, Unit),
    Name(String),
    Negative(Box<Node>),
    Binary(Operator, Box<Node>, Box<Node>),
    Call(Function, Vec<Node>),
}

/// An operator between two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// A function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Function {
    Abs,
    Sign,
    Step,
    Sqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Tanh,
    Atan,
    Min,
    Max,
    Clamp,
}

impl Function {
    /// Names, and how many operands each takes.
    const ALL: [(&'static str, Function, usize); 14] = [
        ("abs", Function::Abs, 1),
        ("sign", Function::Sign, 1),
        ("step", Function::Step, 1),
        ("sqrt", Function::Sqrt, 1),
        ("exp", Function::Exp, 1),
        ("ln", Function::Ln, 1),
        ("sin", Function::Sin, 1),
        ("cos", Function::Cos, 1),
        ("tan", Function::Tan, 1),
        ("tanh", Function::Tanh, 1),
        ("atan", Function::Atan, 1),
        ("min", Function::Min, 2),
        ("max", Function::Max, 2),
        ("clamp", Function::Clamp, 3),
    ];

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        Function::ALL.iter().find(|(_, function, _)| *function == self).map_or("", |(name, ..)| name)
    }
}

type Input<'a> = LocatingSlice<&'a str>;
type Parsed<T> = Result<T, ErrMode<Trouble>>;

/// What the parser could not read: nothing yet where one alternative of several failed.
#[derive(Debug)]
struct Trouble(Option<Error>);

impl<'a> ParserError<Input<'a>> for Trouble {
    type Inner = Trouble;

    fn from_input(_: &Input<'a>) -> Trouble {
        Trouble(None)
    }

    fn into_inner(self) -> Result<Trouble, Trouble> {
        Ok(self)
    }
}

/// An error that no other alternative mends.
fn wrong<T>(at: Place, what: impl Into<String>) -> Parsed<T> {
    Err(ErrMode::Cut(Trouble(Some(Error::new(at, what)))))
}

/// Reads a formula.
pub(crate) fn parse(text: &str) -> Result<Node, Error> {
    bounded(text)?;
    let mut input = LocatingSlice::new(text);
    let nowhere = |at: usize| Error::new(at..text.len(), "a number, a name or a parenthesis is missing here");
    let node = sum(&mut input).map_err(|error| match error {
        ErrMode::Cut(Trouble(Some(error))) => error,
        _ => nowhere(input.current_token_start()),
    })?;
    let at = input.current_token_start();
    match text.get(at..).unwrap_or_default() {
        "" => Ok(node),
        rest => Err(Error::new(at..at + rest.chars().next().map_or(0, char::len_utf8), behind(rest))),
    }
}

/// What stands behind a formula's end.
fn behind(rest: &str) -> String {
    match rest.chars().next() {
        Some(')') => "this parenthesis was never opened".into(),
        Some('[') => "a unit belongs behind a number; names carry theirs".into(),
        Some(c) if c.is_alphanumeric() || c == '(' => "an operator is missing here: write `*` to multiply".into(),
        Some('=' | '<' | '>' | '&' | '|' | '?') => {
            "formulas have no comparisons: `step(x)` is 1 where x > 0, and else 0".into()
        }
        Some(c) => format!("`{c}` is no operator: there are + - * / ^"),
        None => String::new(),
    }
}

/// Refuses what is too long or nests too deep for the stack that reads it.
fn bounded(text: &str) -> Result<(), Error> {
    if text.len() > MOST_BYTES {
        let end = text.char_indices().map(|(at, _)| at).take_while(|at| *at <= MOST_BYTES).last().unwrap_or(0);
        return Err(Error::new(end..text.len(), format!("a formula has at most {MOST_BYTES} characters")));
    }
    let (mut depth, mut powers) = (0usize, 0usize);
    for (at, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            '^' => powers += 1,
            _ => {}
        }
        if depth > MOST_NESTED {
            return Err(Error::new(at..at + 1, format!("parentheses are at most {MOST_NESTED} deep")));
        }
        if powers > MOST_POWERS {
            return Err(Error::new(at..at + 1, format!("a formula has at most {MOST_POWERS} powers")));
        }
    }
    Ok(())
}

fn space(input: &mut Input<'_>) -> Parsed<()> {
    take_while(0.., char::is_whitespace).void().parse_next(input)
}

/// A character with the space behind it.
fn mark<'a>(of: char) -> impl Parser<Input<'a>, (), ErrMode<Trouble>> {
    (of, space).void()
}

fn sum(input: &mut Input<'_>) -> Parsed<Node> {
    space(input)?;
    expression(operand)
        .prefix(dispatch! {peek(any);
            // a run of signs is one: nothing nests for it
            c if is_sign(c) => signs.map(|negative| Prefix(12, if negative { negate } else { keep })),
            _ => fail,
        })
        .infix(dispatch! {any;
            '+' => space.value(Infix::Left(5, |_: &mut Input<'_>, a, b| Ok(binary(Operator::Add, a, b)))),
            '-' | '−' => space.value(Infix::Left(5, |_: &mut Input<'_>, a, b| Ok(binary(Operator::Subtract, a, b)))),
            '*' | '·' => space.value(Infix::Left(7, |_: &mut Input<'_>, a, b| Ok(binary(Operator::Multiply, a, b)))),
            '/' => space.value(Infix::Left(7, |_: &mut Input<'_>, a, b| Ok(binary(Operator::Divide, a, b)))),
            '^' => space.value(Infix::Right(14, |_: &mut Input<'_>, a, b| Ok(binary(Operator::Power, a, b)))),
            _ => fail,
        })
        .parse_next(input)
}

fn binary(operator: Operator, a: Node, b: Node) -> Node {
    Node { at: a.at.start..b.at.end, kind: Kind::Binary(operator, Box::new(a), Box::new(b)) }
}

fn negate(_: &mut Input<'_>, node: Node) -> Parsed<Node> {
    Ok(Node { at: node.at.clone(), kind: Kind::Negative(Box::new(node)) })
}

fn keep(_: &mut Input<'_>, node: Node) -> Parsed<Node> {
    Ok(node)
}

/// Signs one behind the other: whether they come to a minus.
fn signs(input: &mut Input<'_>) -> Parsed<bool> {
    let signs = take_while(1.., |c: char| is_sign(c) || c.is_whitespace()).parse_next(input)?;
    Ok(signs.chars().filter(|c| matches!(c, '-' | '−')).count() % 2 == 1)
}

fn is_sign(c: char) -> bool {
    matches!(c, '+' | '-' | '−')
}

fn operand(input: &mut Input<'_>) -> Parsed<Node> {
    let start = input.current_token_start();
    let next = opt(peek(any)).parse_next(input)?;
    match next {
        Some('(') => {
            mark('(').parse_next(input)?;
            let inner = sum(input)?;
            close(input, start)?;
            Ok(Node { at: start..input.previous_token_end(), ..inner })
        }
        // left to the prefixes
        Some(c) if is_sign(c) => fail(input),
        Some(c) if c.is_ascii_digit() || c == '.' => number(input),
        Some(c) if c.is_alphabetic() || c == '_' => named(input),
        Some(c) => wrong(
            start..start + c.len_utf8(),
            match c {
                ')' => "something is missing before this parenthesis".into(),
                '*' | '/' | '^' | '·' | ',' => format!("something is missing before `{c}`"),
                _ => format!("`{c}` is nothing a formula is made of: numbers, names, + - * / ^ and ( )"),
            },
        ),
        None => wrong(start..start, "a number, a name or a parenthesis is missing here"),
    }
}

fn close(input: &mut Input<'_>, opened: usize) -> Parsed<()> {
    let at = input.current_token_start();
    match opt(mark(')')).parse_next(input)? {
        Some(()) => Ok(()),
        None => match opt(peek(any)).parse_next(input)? {
            Some(c) if c != ',' => wrong(at..at + c.len_utf8(), behind(c.encode_utf8(&mut [0; 4]))),
            _ => wrong(opened..at.max(opened + 1), "this parenthesis is not closed"),
        },
    }
}

/// `12`, `0.5`, `.5`, `1e-3`, each perhaps with `[unit]`.
fn number(input: &mut Input<'_>) -> Parsed<Node> {
    let start = input.current_token_start();
    let digits = |input: &mut Input<'_>| -> Parsed<()> {
        take_while(0.., |c: char| c.is_ascii_digit()).void().parse_next(input)
    };
    let exponent = (one_of(['e', 'E']), opt(one_of(['+', '-'])), take_while(1.., |c: char| c.is_ascii_digit())).void();
    // `2exp(x)` is no number with an exponent, and `2 e` none either
    let text = (digits, opt(('.', digits)), opt(exponent)).take().parse_next(input)?;
    let end = input.current_token_start();
    let value = match text.parse::<f64>() {
        Ok(value) if value.is_finite() => value,
        _ => return wrong(start..end.max(start + 1), format!("`{text}` is no number")),
    };
    space(input)?;
    let unit = opt(bracketed).parse_next(input)?.unwrap_or(Unit { si: 1.0, dimension: Default::default() });
    Ok(Node { at: start..end, kind: Kind::Number(value, unit) })
}

/// `[unit]`.
fn bracketed(input: &mut Input<'_>) -> Parsed<Unit> {
    let opened = input.current_token_start();
    '['.parse_next(input)?;
    let from = input.current_token_start();
    let text = take_while(0.., |c: char| c != ']').parse_next(input)?;
    let end = input.current_token_start();
    if opt(']').parse_next(input)?.is_none() {
        return wrong(opened..end.max(opened + 1), "this bracket is not closed");
    }
    space(input)?;
    Unit::parse(text).or_else(|error| wrong(from + error.at.start..from + error.at.end, error.what))
}

/// A name, or a function with its operands.
fn named(input: &mut Input<'_>) -> Parsed<Node> {
    let start = input.current_token_start();
    let name = take_while(1.., |c: char| c.is_alphanumeric() || c == '_').parse_next(input)?;
    let end = input.current_token_start();
    space(input)?;
    if opt(not('(')).parse_next(input)?.is_some() {
        return Ok(Node { at: start..end, kind: Kind::Name(name.into()) });
    }
    let Some((_, function, operands)) = Function::ALL.iter().find(|(known, ..)| *known == name) else {
        let names: Vec<&str> = Function::ALL.iter().map(|(name, ..)| *name).collect();
        let pow = if name == "pow" { "a power is written `x^y`; " } else { "" };
        return wrong(start..end, format!("there is no function `{name}`: {pow}there are {}", names.join(", ")));
    };
    let opened = input.current_token_start();
    mark('(').parse_next(input)?;
    let found: Vec<Node> = cut_err(separated(1.., sum, mark(','))).parse_next(input)?;
    close(input, opened)?;
    let place = start..input.previous_token_end().max(end);
    if found.len() != *operands {
        let wanted = if *operands == 1 { "one operand".into() } else { format!("{operands} operands") };
        return wrong(start..end, format!("`{name}` takes {wanted}, and has {} here", found.len()));
    }
    Ok(Node { at: place, kind: Kind::Call(*function, found) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With parentheses wherever there is an operator.
    fn whole(node: &Node) -> String {
        match &node.kind {
            Kind::Number(value, _) => value.to_string(),
            Kind::Name(name) => name.clone(),
            Kind::Negative(of) => format!("(-{})", whole(of)),
            Kind::Binary(operator, a, b) => {
                let sign = match operator {
                    Operator::Add => '+',
                    Operator::Subtract => '-',
                    Operator::Multiply => '*',
                    Operator::Divide => '/',
                    Operator::Power => '^',
                };
                format!("({}{sign}{})", whole(a), whole(b))
            }
            Kind::Call(function, of) => {
                format!("{}({})", function.name(), of.iter().map(whole).collect::<Vec<_>>().join(","))
            }
        }
    }

    #[test]
    fn the_page_names_every_function() {
        let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/own-physics.md")).unwrap();
        for (name, ..) in Function::ALL {
            assert!(page.contains(&format!("`{name}`")) || page.contains(&format!("`{name}(")), "{name}");
        }
    }

    #[test]
    fn operators_bind_as_on_paper() {
        for (text, expected) in [
            ("a+b*c", "(a+(b*c))"),
            ("a-b-c", "((a-b)-c)"),
            ("a/b/c", "((a/b)/c)"),
            ("2^3^2", "(2^(3^2))"),
            ("-x^2", "(-(x^2))"),
            ("2^-3*4", "((2^(-3))*4)"),
            ("-a*b", "((-a)*b)"),
            ("a - -b", "(a-(-b))"),
            ("--a", "a"),
            ("+a", "a"),
            (" ( a + b ) * c ", "((a+b)*c)"),
            ("max(a, b*c) + .5e-1", "(max(a,(b*c))+0.05)"),
            ("2.5 [mm] * exp(-x)", "(2.5*exp((-x)))"),
            ("1e3", "1000"),
            ("clamp(x, 0, 1)", "clamp(x,0,1)"),
        ] {
            assert_eq!(parse(text).map(|node| whole(&node)), Ok(expected.into()), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_said_with_its_place() {
        for (text, at, what) in [
            ("", 0..0, "missing here"),
            ("a +", 3..3, "missing here"),
            ("a + * b", 4..5, "missing before `*`"),
            ("(a + b", 0..6, "not closed"),
            ("a + b)", 5..6, "never opened"),
            ("2 a", 2..3, "operator is missing"),
            ("2exp(x)", 1..2, "operator is missing"),
            ("(2 a)", 3..4, "operator is missing"),
            ("a > b", 2..3, "step(x)"),
            ("sin x", 4..5, "operator is missing"),
            ("erf(x)", 0..3, "no function `erf`"),
            ("pow(x, 2)", 0..3, "x^y"),
            ("max(a)", 0..3, "takes 2 operands"),
            ("max(a,)", 6..7, "missing before this parenthesis"),
            ("sin()", 4..5, "missing before this parenthesis"),
            ("a $ b", 2..3, "`$`"),
            ("2 [parsec]", 3..9, "no unit"),
            ("2 [mm", 2..5, "not closed"),
            ("x [mm]", 2..3, "behind a number"),
            (".", 0..1, "no number"),
            ("1e999", 0..5, "no number"),
        ] {
            let error = parse(text).unwrap_err();
            assert_eq!(error.at, at, "{text}: {error}");
            assert!(error.what.contains(what), "{text}: {error}");
        }
        assert!(parse(&"x+".repeat(400)).unwrap_err().what.contains("500"));
        assert!(parse(&"(".repeat(200)).unwrap_err().what.contains("deep"));
        assert!(parse(&"x^".repeat(200)).unwrap_err().what.contains("powers"));
        assert!(parse(&format!("{}x", "-".repeat(400))).is_ok());
    }
}
