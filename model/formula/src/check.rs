//! Whether the units in a formula fit together.

use crate::error::Error;
use crate::syntax::{Function, Kind, Node, Operator};
use crate::unit::Dimension;

/// A name that a formula may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quantity<'a> {
    /// As it stands in the formula.
    pub name: &'a str,
    /// What it measures.
    pub dimension: Dimension,
}

/// What a formula measures: something, or anything, as a zero does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Measures {
    Anything,
    Known(Dimension),
}

impl Measures {
    fn is(self, dimension: Dimension) -> bool {
        self == Measures::Anything || self == Measures::Known(dimension)
    }

    fn dimension(self) -> Dimension {
        match self {
            Measures::Anything => Dimension::NONE,
            Measures::Known(dimension) => dimension,
        }
    }
}

/// Refuses a formula whose parts do not fit together, or that does not measure `wanted`.
pub(crate) fn check(node: &Node, names: &[Quantity<'_>], wanted: Dimension) -> Result<(), Error> {
    match measured(node, names)? {
        found if found.is(wanted) => Ok(()),
        found => {
            Err(Error::new(node.at.clone(), format!("this is in {}, and should be in {wanted}", found.dimension())))
        }
    }
}

fn measured(node: &Node, names: &[Quantity<'_>]) -> Result<Measures, Error> {
    match &node.kind {
        Kind::Number(value, unit) if *value == 0.0 && unit.dimension == Dimension::NONE => Ok(Measures::Anything),
        Kind::Number(_, unit) => Ok(Measures::Known(unit.dimension)),
        Kind::Name(name) => match names.iter().find(|quantity| quantity.name == name) {
            Some(quantity) => Ok(Measures::Known(quantity.dimension)),
            None => Err(Error::new(node.at.clone(), unknown(name, names))),
        },
        Kind::Negative(of) => measured(of, names),
        Kind::Binary(operator, a, b) => {
            let of = (measured(a, names)?, measured(b, names)?);
            match operator {
                Operator::Add | Operator::Subtract => same(node, [of.0, of.1], "added"),
                Operator::Multiply => Ok(Measures::Known(of.0.dimension() * of.1.dimension())),
                Operator::Divide => Ok(Measures::Known(of.0.dimension() / of.1.dimension())),
                Operator::Power => power(a, b, of),
            }
        }
        Kind::Call(function, operands) => {
            let found = operands.iter().map(|operand| measured(operand, names)).collect::<Result<Vec<_>, _>>()?;
            call(*function, node, operands, &found)
        }
    }
}

fn call(function: Function, node: &Node, operands: &[Node], found: &[Measures]) -> Result<Measures, Error> {
    let pure = Measures::Known(Dimension::NONE);
    match function {
        Function::Abs => Ok(found[0]),
        Function::Sign | Function::Step => Ok(pure),
        Function::Sqrt => root(&operands[0], found[0]),
        Function::Min | Function::Max => same(node, [found[0], found[1]], "compared"),
        Function::Clamp => {
            let bounds = same(node, [found[1], found[2]], "compared")?;
            same(node, [found[0], bounds], "compared")
        }
        Function::Exp
        | Function::Ln
        | Function::Sin
        | Function::Cos
        | Function::Tan
        | Function::Tanh
        | Function::Atan => match found[0].is(Dimension::NONE) {
            true => Ok(pure),
            false => Err(Error::new(
                operands[0].at.clone(),
                format!(
                    "`{}` wants a number without unit, and this is in {}: divide it by something of that unit",
                    function.name(),
                    found[0].dimension()
                ),
            )),
        },
    }
}

fn same(node: &Node, [a, b]: [Measures; 2], what: &str) -> Result<Measures, Error> {
    match (a, b) {
        (Measures::Anything, other) | (other, Measures::Anything) => Ok(other),
        (Measures::Known(a), Measures::Known(b)) if a == b => Ok(Measures::Known(a)),
        (Measures::Known(a), Measures::Known(b)) => Err(Error::new(
            node.at.clone(),
            format!("{a} and {b} cannot be {what}; a number carries its unit in brackets: `20 [K]`"),
        )),
    }
}

fn root(operand: &Node, of: Measures) -> Result<Measures, Error> {
    let root = of.dimension().power(0.5);
    root.map(Measures::Known).ok_or_else(|| Error::new(operand.at.clone(), "this has no square root that is a unit"))
}

fn power(base: &Node, exponent: &Node, of: (Measures, Measures)) -> Result<Measures, Error> {
    if !of.1.is(Dimension::NONE) {
        let what = format!("an exponent has no unit, and this is in {}", of.1.dimension());
        return Err(Error::new(exponent.at.clone(), what));
    }
    if of.0.is(Dimension::NONE) {
        return Ok(Measures::Known(Dimension::NONE));
    }
    let raised = constant(exponent).and_then(|exponent| of.0.dimension().power(exponent));
    raised.map(Measures::Known).ok_or_else(|| {
        let what = format!("{} can be raised to a number only, such as 2 or 0.5", of.0.dimension());
        Error::new(base.at.start..exponent.at.end, what)
    })
}

/// The value of an exponent that is a number.
fn constant(node: &Node) -> Option<f64> {
    match &node.kind {
        Kind::Number(value, unit) => Some(value * unit.si),
        Kind::Negative(of) => constant(of).map(|value| -value),
        Kind::Binary(Operator::Divide, a, b) => Some(constant(a)? / constant(b)?),
        _ => None,
    }
}

fn unknown(name: &str, names: &[Quantity<'_>]) -> String {
    let known: Vec<&str> = names.iter().map(|quantity| quantity.name).collect();
    format!("there is no `{name}` here: there are {}", known.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::parse;
    use crate::unit::Unit;

    fn of(unit: &str) -> Dimension {
        Unit::parse(unit).unwrap().dimension
    }

    fn checked(text: &str, wanted: &str) -> Result<(), Error> {
        let names = [("x", "m"), ("t", "s"), ("warm", "K"), ("share", "1"), ("k", "N/m"), ("sigma", "MPa")];
        let names = names.map(|(name, unit)| Quantity { name, dimension: of(unit) });
        check(&parse(text).unwrap(), &names, of(wanted))
    }

    #[test]
    fn what_fits_together_is_taken() {
        for (text, wanted) in [
            ("k * x", "N"),
            ("-k * (x - 2 [mm]) * share", "N"),
            ("0", "N"),
            ("max(k * x, 0)", "N"),
            ("x / t", "m/s"),
            ("x^2 / t^2", "m²/s²"),
            ("sqrt(x * x) + abs(x)", "m"),
            ("x^-1", "1/m"),
            ("x^(1/2) * x^0.5", "m"),
            ("share^share", "1"),
            ("exp(-t / 2 [s])", "1"),
            ("tanh(x / 1 [mm]) * 3 [mW]", "W"),
            ("step(warm - 5 [K])", "1"),
            ("sigma / 70 [GPa]", "1"),
            ("k * x - 0", "J/m"),
            ("clamp(x, 0, 1 [mm])", "m"),
        ] {
            assert_eq!(checked(text, wanted), Ok(()), "{text}");
        }
    }

    #[test]
    fn what_does_not_is_refused_with_its_place() {
        for (text, at, what) in [
            ("x + t", 0..5, "m and s cannot be added"),
            ("1 + x + x", 0..5, "a number without unit and m"),
            ("exp(t)", 4..5, "`exp` wants a number without unit, and this is in s"),
            ("k * y", 4..5, "no `y` here: there are x, t"),
            ("x^t", 2..3, "exponent has no unit"),
            ("x^share", 0..7, "raised to a number only"),
            ("max(x, 1)", 0..9, "compared"),
            ("k * warm", 0..8, "should be in N"),
        ] {
            let error = checked(text, "N").unwrap_err();
            assert!(error.what.contains(what), "{text}: {error}");
            assert_eq!(error.at, at, "{text}: {error}");
        }
    }
}
