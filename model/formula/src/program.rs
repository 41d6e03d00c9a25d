//! A formula as the operations that evaluate it, on a stack.

use crate::check::{Quantity, check};
use crate::error::Error;
use crate::syntax::{Function, Kind, Node, Operator, parse};
use crate::unit::Dimension;

/// The deepest stack; the bounds of the syntax keep it below.
const MOST_DEPTH: usize = 32;

/// A formula that can be evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    text: String,
    operations: Vec<Operation>,
}

/// One step of the evaluation. Operands are taken from the top of the stack, and the result is put there.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Number(f64),
    Name(usize),
    Negate,
    Binary(Operator),
    /// To an exponent that is a whole number.
    Powi(i32),
    Call(Function),
}

impl Formula {
    /// Reads a formula over `names`, which measures `dimension`.
    ///
    /// # Errors
    /// What cannot be read, a name that is not there, or units that do not fit together, each with its place.
    pub fn new(text: &str, names: &[Quantity<'_>], dimension: Dimension) -> Result<Formula, Error> {
        let node = parse(text)?;
        check(&node, names, dimension)?;
        let mut operations = Vec::new();
        compile(&node, names, &mut operations);
        if depth(&operations) > MOST_DEPTH {
            return Err(Error::new(0..text.len(), "this formula nests too deep: write it in simpler parts"));
        }
        Ok(Formula { text: text.into(), operations })
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether it uses the name at this place of the names it was read over.
    pub fn uses(&self, name: usize) -> bool {
        self.operations.contains(&Operation::Name(name))
    }

    /// Its value in SI, with the value of each name in SI. Not finite where the formula is not defined.
    ///
    /// # Panics
    /// Where `values` are fewer than the names it was read over.
    pub fn value(&self, values: &[f64]) -> f64 {
        self.run::<f64>(|name| values[name])
    }

    /// Its value, and its derivative by the name at `by`. At a kink the derivative is that of one side.
    ///
    /// # Panics
    /// Where `values` are fewer than the names it was read over.
    pub fn tangent(&self, values: &[f64], by: usize) -> (f64, f64) {
        let Dual { value, slope } =
            self.run(|name| Dual { value: values[name], slope: if name == by { 1.0 } else { 0.0 } });
        (value, slope)
    }

    fn run<T: Number>(&self, named: impl Fn(usize) -> T) -> T {
        let mut stack = [T::of(0.0); MOST_DEPTH];
        let mut top = 0;
        for operation in &self.operations {
            match *operation {
                Operation::Number(value) => {
                    stack[top] = T::of(value);
                    top += 1;
                }
                Operation::Name(name) => {
                    stack[top] = named(name);
                    top += 1;
                }
                Operation::Negate => stack[top - 1] = T::of(0.0).minus(stack[top - 1]),
                Operation::Powi(exponent) => stack[top - 1] = stack[top - 1].powi(exponent),
                Operation::Binary(operator) => {
                    top -= 1;
                    let (a, b) = (stack[top - 1], stack[top]);
                    stack[top - 1] = match operator {
                        Operator::Add => a.plus(b),
                        Operator::Subtract => a.minus(b),
                        Operator::Multiply => a.times(b),
                        Operator::Divide => a.over(b),
                        Operator::Power => a.powf(b),
                    };
                }
                Operation::Call(function) => {
                    top -= operands(function) - 1;
                    let a = stack[top - 1];
                    stack[top - 1] = match function {
                        Function::Min => {
                            if stack[top].value() < a.value() {
                                stack[top]
                            } else {
                                a
                            }
                        }
                        Function::Max => {
                            if stack[top].value() > a.value() {
                                stack[top]
                            } else {
                                a
                            }
                        }
                        Function::Clamp => {
                            let (low, high) = (stack[top], stack[top + 1]);
                            let raised = if a.value() < low.value() { low } else { a };
                            if raised.value() > high.value() { high } else { raised }
                        }
                        function => a.call(function),
                    };
                }
            }
        }
        stack[0]
    }
}

fn operands(function: Function) -> usize {
    match function {
        Function::Min | Function::Max => 2,
        Function::Clamp => 3,
        _ => 1,
    }
}

/// Puts the operations of `node` behind the others; what has numbers only is worked out at once.
fn compile(node: &Node, names: &[Quantity<'_>], operations: &mut Vec<Operation>) {
    let from = operations.len();
    match &node.kind {
        Kind::Number(value, unit) => operations.push(Operation::Number(value * unit.si)),
        Kind::Name(name) => {
            // `check` has found each
            let at = names.iter().position(|quantity| quantity.name == name).unwrap_or(0);
            operations.push(Operation::Name(at));
        }
        Kind::Negative(of) => {
            compile(of, names, operations);
            operations.push(Operation::Negate);
        }
        Kind::Binary(operator, a, b) => {
            compile(a, names, operations);
            compile(b, names, operations);
            match (operator, operations.last()) {
                (Operator::Power, Some(&Operation::Number(exponent)))
                    if exponent.fract() == 0.0 && exponent.abs() < 64.0 =>
                {
                    operations.pop();
                    operations.push(Operation::Powi(exponent as i32));
                }
                _ => operations.push(Operation::Binary(*operator)),
            }
        }
        Kind::Call(function, of) => {
            for operand in of {
                compile(operand, names, operations);
            }
            operations.push(Operation::Call(*function));
        }
    }
    if !operations[from..].iter().any(|operation| matches!(operation, Operation::Name(_))) {
        let part = Formula { text: String::new(), operations: operations.split_off(from) };
        if depth(&part.operations) <= MOST_DEPTH {
            operations.push(Operation::Number(part.value(&[])));
        } else {
            operations.extend(part.operations);
        }
    }
}

/// The most values that are on the stack at once.
fn depth(operations: &[Operation]) -> usize {
    let (mut now, mut most) = (0usize, 0);
    for operation in operations {
        match operation {
            Operation::Number(_) | Operation::Name(_) => now += 1,
            Operation::Negate | Operation::Powi(_) => {}
            Operation::Binary(_) => now -= 1,
            Operation::Call(function) => now -= operands(*function) - 1,
        }
        most = most.max(now);
    }
    most
}

/// What a formula is evaluated in: numbers, or numbers with their derivative.
trait Number: Copy {
    fn of(value: f64) -> Self;
    fn value(self) -> f64;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    fn powi(self, exponent: i32) -> Self;
    fn powf(self, exponent: Self) -> Self;
    fn call(self, function: Function) -> Self;
}

impl Number for f64 {
    fn of(value: f64) -> f64 {
        value
    }
    fn value(self) -> f64 {
        self
    }
    fn plus(self, other: f64) -> f64 {
        self + other
    }
    fn minus(self, other: f64) -> f64 {
        self - other
    }
    fn times(self, other: f64) -> f64 {
        self * other
    }
    fn over(self, other: f64) -> f64 {
        self / other
    }
    fn powi(self, exponent: i32) -> f64 {
        f64::powi(self, exponent)
    }
    fn powf(self, exponent: f64) -> f64 {
        f64::powf(self, exponent)
    }
    fn call(self, function: Function) -> f64 {
        called(function, self).0
    }
}

/// A number and its derivative.
#[derive(Clone, Copy)]
struct Dual {
    value: f64,
    slope: f64,
}

impl Number for Dual {
    fn of(value: f64) -> Dual {
        Dual { value, slope: 0.0 }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn plus(self, other: Dual) -> Dual {
        Dual { value: self.value + other.value, slope: self.slope + other.slope }
    }
    fn minus(self, other: Dual) -> Dual {
        Dual { value: self.value - other.value, slope: self.slope - other.slope }
    }
    fn times(self, other: Dual) -> Dual {
        Dual { value: self.value * other.value, slope: self.slope * other.value + self.value * other.slope }
    }
    fn over(self, other: Dual) -> Dual {
        let value = self.value / other.value;
        Dual { value, slope: (self.slope - value * other.slope) / other.value }
    }
    fn powi(self, exponent: i32) -> Dual {
        let value = self.value.powi(exponent);
        // of a constant, 0 and not 0 · ∞
        let slope = match self.slope == 0.0 || exponent == 0 {
            true => 0.0,
            false => f64::from(exponent) * self.value.powi(exponent - 1) * self.slope,
        };
        Dual { value, slope }
    }
    fn powf(self, exponent: Dual) -> Dual {
        let value = self.value.powf(exponent.value);
        let mut slope = 0.0;
        if self.slope != 0.0 && exponent.value != 0.0 {
            slope += exponent.value * self.value.powf(exponent.value - 1.0) * self.slope;
        }
        if exponent.slope != 0.0 && value != 0.0 {
            slope += value * self.value.ln() * exponent.slope;
        }
        Dual { value, slope }
    }
    fn call(self, function: Function) -> Dual {
        let (value, by) = called(function, self.value);
        Dual { value, slope: if self.slope == 0.0 { 0.0 } else { by * self.slope } }
    }
}

/// A function of one operand, and its derivative.
#[inline(always)]
fn called(function: Function, x: f64) -> (f64, f64) {
    match function {
        Function::Abs => (x.abs(), if x < 0.0 { -1.0 } else { 1.0 }),
        Function::Sign => (if x == 0.0 { 0.0 } else { x.signum() }, 0.0),
        Function::Step => (if x > 0.0 { 1.0 } else { 0.0 }, 0.0),
        Function::Sqrt => (x.sqrt(), 0.5 / x.sqrt()),
        Function::Exp => (x.exp(), x.exp()),
        Function::Ln => (x.ln(), 1.0 / x),
        Function::Sin => (x.sin(), x.cos()),
        Function::Cos => (x.cos(), -x.sin()),
        Function::Tan => (x.tan(), 1.0 + x.tan() * x.tan()),
        Function::Tanh => (x.tanh(), 1.0 - x.tanh() * x.tanh()),
        Function::Atan => (x.atan(), 1.0 / (1.0 + x * x)),
        // those of several operands are worked out where they are on the stack
        Function::Min | Function::Max | Function::Clamp => (x, 1.0),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const NAMES: [Quantity<'static>; 2] =
        [Quantity { name: "x", dimension: Dimension::NONE }, Quantity { name: "y", dimension: Dimension::NONE }];

    fn formula(text: &str) -> Formula {
        Formula::new(text, &NAMES, Dimension::NONE).unwrap()
    }

    #[test]
    fn values_are_those_of_arithmetic() {
        let (x, y) = (0.7f64, -1.3f64);
        for (text, expected) in [
            ("x + 2*y - x/y", x + 2.0 * y - x / y),
            ("-x^2", -x * x),
            ("x^y", x.powf(y)),
            ("2^3^2", 512.0),
            ("x^-2", 1.0 / (x * x)),
            ("abs(y) + sign(y) + step(x) + step(y)", 1.3 - 1.0 + 1.0),
            ("sqrt(x) + exp(y) + ln(x)", x.sqrt() + y.exp() + x.ln()),
            ("sin(x) * cos(y) / tan(x)", x.sin() * y.cos() / x.tan()),
            ("tanh(x) - atan(y)", x.tanh() - y.atan()),
            ("min(x, y) + 10 * max(x, y)", y + 10.0 * x),
            ("clamp(y, -1, 1) + clamp(x, -1, 1) + clamp(5, 0, x)", -1.0 + x + x),
            ("3 * (2 + 4)", 18.0),
        ] {
            let found = formula(text).value(&[x, y]);
            assert!((found - expected).abs() < 1e-14 * expected.abs().max(1.0), "{text}: {found}, not {expected}");
        }
    }

    #[test]
    fn what_has_no_names_is_worked_out_once() {
        assert_eq!(formula("3 * (2 + 4) - exp(0)").operations, [Operation::Number(17.0)]);
        assert!(formula("x * 2").uses(0) && !formula("x * 2").uses(1));
    }

    #[test]
    fn a_formula_that_is_as_wide_as_it_may_be_is_evaluated() {
        let wide = format!("{}x{}", "1+(x*".repeat(12), ")".repeat(12));
        assert_eq!(formula(&wide).value(&[1.0, 0.0]), 13.0);
        // operands that wait: each of 12 levels holds two
        let deep = format!("{}x{}", "clamp(x,x,".repeat(12), ")".repeat(12));
        assert_eq!(formula(&deep).value(&[2.0, 0.0]), 2.0);
    }

    /// Formulas that are smooth where x and y are in 0.2 to 2.
    fn smooth() -> impl Strategy<Value = String> {
        let leaf = prop_oneof![
            Just("x".to_string()),
            Just("y".to_string()),
            (1u32..30).prop_map(|n| format!("{}", f64::from(n) / 8.0))
        ];
        leaf.prop_recursive(4, 24, 3, |inner| {
            prop_oneof![
                (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a} + {b})")),
                (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a} - {b})")),
                (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("{a} * {b}")),
                (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("{a} / (1.5 + ({b})^2)")),
                inner.clone().prop_map(|a| format!("sin({a})")),
                inner.clone().prop_map(|a| format!("-tanh({a})")),
                inner.clone().prop_map(|a| format!("atan({a})")),
                inner.clone().prop_map(|a| format!("exp(-({a})^2)")),
                inner.clone().prop_map(|a| format!("sqrt(1 + ({a})^2)")),
                inner.clone().prop_map(|a| format!("ln(1 + ({a})^2)")),
                (inner.clone(), inner).prop_map(|(a, b)| format!("(1 + ({a})^2)^cos({b})")),
            ]
        })
    }

    proptest! {
        #[test]
        fn the_derivative_is_that_of_differences(text in smooth(), x in 0.2f64..2.0, y in 0.2f64..2.0) {
            prop_assume!(text.len() < 500);
            let Ok(formula) = Formula::new(&text, &NAMES, Dimension::NONE) else { return Ok(()) };
            let h = 1e-5;
            let (value, slope) = formula.tangent(&[x, y], 0);
            prop_assert_eq!(value, formula.value(&[x, y]));
            let at = |x: f64| formula.value(&[x, y]);
            let (differences, coarser) = ((at(x + h) - at(x - h)) / (2.0 * h), (at(x + 3.0 * h) - at(x - 3.0 * h)) / (6.0 * h));
            // where two steps agree on it
            let scale = differences.abs().max(value.abs()).max(1.0);
            prop_assume!((differences - coarser).abs() < 1e-5 * scale);
            prop_assert!((slope - differences).abs() < 1e-4 * scale, "{}: {} against {}", text, slope, differences);
        }

        #[test]
        fn no_text_is_too_much(text in "[-+*/^()\\[\\],. 0-9a-zxyµ°²]{0,80}|\\PC{0,60}") {
            match Formula::new(&text, &NAMES, Dimension::NONE) {
                Ok(formula) => { formula.value(&[1.0, 2.0]); }
                Err(error) => prop_assert!(text.get(error.at.clone()).is_some(), "{:?}", error.at),
            }
        }
    }
}
