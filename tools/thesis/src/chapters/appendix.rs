//! Appendix A: control and estimation reviewed. Its equations carry no numbers.

use sinew_state_space::convert::{discretise, discretise_measurement_noise, discretise_noise, exponential};
use sinew_state_space::derive::derivative;
use sinew_state_space::place::{place, place_observer};
use sinew_state_space::rank::{controllability, controllability_rank, observability, observability_rank};
use sinew_state_space::riccati::dlqe;
use sinew_state_space::servo::augment;
use sinew_state_space::{Complex, DMatrix, eigenvalues};

use super::nine::observer_error;
use super::ten::linearisation;
use crate::chapter::Chapter::A;
use crate::chapter::Place::Displayed;
use crate::found::{Found, Tried};
use crate::lab::Lab;
use crate::row::{Computed, Row};

const CONVERT: &str = "control/state-space/src/convert.rs";
const DERIVE: &str = "control/state-space/src/derive.rs";
const RANK: &str = "control/state-space/src/rank.rs";
const PLACE: &str = "control/state-space/src/place.rs";
const SERVO: &str = "control/state-space/src/servo.rs";
const RICCATI: &str = "control/state-space/src/riccati.rs";

/// A damped pair with one input and one output.
fn plant() -> (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>) {
    (
        DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -4.0, -0.8]),
        DMatrix::from_row_slice(2, 1, &[0.0, 2.0]),
        DMatrix::from_row_slice(1, 2, &[1.0, 0.0]),
    )
}

/// Sampled, the state steps to where it goes continuously.
fn sampled(_: &Lab, found: &mut Found) -> Computed {
    let (a, b, c) = plant();
    let (ad, bd) = discretise(&a, &b, 0.1)?;
    let start = DMatrix::from_row_slice(2, 1, &[1.0, 0.0]);
    let mut x = start.clone();
    for _ in 0..10 {
        x = &ad * &x + &bd * 0.5;
    }
    // x(t) = e^At (x_0 − x_∞) + x_∞ under a constant input
    let rest = -(a.clone().try_inverse().ok_or("no inverse")?) * &b * 0.5;
    let stated = exponential(&a)? * (start - &rest) + &rest;
    found.near("output after ten steps of 0.1 s", "1", (&c * &stated)[0], 1e-9, (&c * &x)[0]);
    found.near("its rate", "1", stated[1], 1e-9, x[1]);
    Ok(())
}

/// The matrices of a sampled system by closed forms of one state.
fn closed_forms(_: &Lab, found: &mut Found) -> Computed {
    let one = |value: f64| DMatrix::from_element(1, 1, value);
    let (ad, bd) = discretise(&one(-2.0), &one(3.0), 0.1)?;
    found.near("A_d, e^(−2 Δt)", "1", (-0.2f64).exp(), 1e-12, ad[0]);
    found.near("B_d, A⁻¹(A_d − I) B", "1", 1.5 * (1.0 - (-0.2f64).exp()), 1e-12, bd[0]);
    found.near(
        "Q_d of Q = 5",
        "1",
        5.0 * (1.0 - (-0.4f64).exp()) / 4.0,
        1e-12,
        discretise_noise(&one(-2.0), &one(5.0), 0.1)?[0],
    );
    found.near("R_d of R = 0.3", "1", 3.0, 1e-12, discretise_measurement_noise(&one(0.3), 0.1)?[0]);
    Ok(())
}

/// Over a short step the first terms do.
fn short_steps(_: &Lab, found: &mut Found) -> Computed {
    let (a, b, _) = plant();
    let dt = 1e-4;
    let (ad, bd) = discretise(&a, &b, dt)?;
    let q = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 1.0]);
    found.below(
        "A_d − (I + A Δt), of A Δt",
        "1",
        1e-3,
        (ad - DMatrix::identity(2, 2) - &a * dt).norm() / (&a * dt).norm(),
    );
    found.below("B_d − B Δt, of B Δt", "1", 1e-3, (bd - &b * dt).norm() / (&b * dt).norm());
    found.below("Q_d − Q Δt, of Q Δt", "1", 1e-3, (discretise_noise(&a, &q, dt)? - &q * dt).norm() / (&q * dt).norm());
    Ok(())
}

/// Van Loan's exponentials of blocks.
fn van_loan(_: &Lab, found: &mut Found) -> Computed {
    let (a, b, _) = plant();
    let dt = 0.1;
    let (ad, bd) = discretise(&a, &b, dt)?;
    let mut block = DMatrix::zeros(3, 3);
    block.view_mut((0, 0), (2, 2)).copy_from(&(&a * dt));
    block.view_mut((0, 2), (2, 1)).copy_from(&(&b * dt));
    let block = exponential(&block)?;
    found.nothing("A_d from the block", "1", 1e-12, (block.view((0, 0), (2, 2)) - &ad).norm());
    found.nothing("B_d from the block", "1", 1e-12, (block.view((0, 2), (2, 1)) - &bd).norm());
    let q = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 1.0]);
    let mut block = DMatrix::zeros(4, 4);
    block.view_mut((0, 0), (2, 2)).copy_from(&(&a * -dt));
    block.view_mut((0, 2), (2, 2)).copy_from(&(&q * dt));
    block.view_mut((2, 2), (2, 2)).copy_from(&(a.transpose() * dt));
    let block = exponential(&block)?;
    let (c12, c22) = (block.view((0, 2), (2, 2)).clone_owned(), block.view((2, 2), (2, 2)).clone_owned());
    found.nothing("A_d = C_22ᵀ", "1", 1e-12, (c22.transpose() - &ad).norm());
    found.nothing("Q_d = C_22ᵀ C_12", "1", 1e-12, (c22.transpose() * c12 - discretise_noise(&a, &q, dt)?).norm());
    Ok(())
}

/// A difference of two values, and the complex step, beside the derivative.
fn derivatives(_: &Lab, found: &mut Found) -> Computed {
    let f = |x: Complex<f64>| (x * 3.0).exp() / (x + 2.0);
    let (x, e) = (0.7f64, (2.1f64).exp());
    let exact = e * (3.0 * (x + 2.0) - 1.0) / (x + 2.0).powi(2);
    let real = |x: f64| f(Complex::new(x, 0.0)).re;
    found.near("difference over 10⁻⁶", "1", exact, 1e-4 * exact, (real(x + 1e-6) - real(x)) / 1e-6);
    found.near("complex step", "1", exact, 1e-14 * exact, derivative(f, x));
    found.above("error of the difference over 10⁻¹², over that of the complex step", "1", 1e3, {
        let difference = (real(x + 1e-12) - real(x)) / 1e-12 - exact;
        difference.abs() / (derivative(f, x) - exact).abs().max(1e-15)
    });
    Ok(())
}

fn reached(_: &Lab, found: &mut Found) -> Computed {
    let (a, b, _) = plant();
    found.nothing(
        "[B, A B] as stated",
        "1",
        0.0,
        (controllability(&a, &b)? - DMatrix::from_columns(&[b.column(0), (&a * &b).column(0)])).norm(),
    );
    found.equal("its rank", "1", 2.0, controllability_rank(&a, &b)? as f64);
    let hidden = DMatrix::from_row_slice(2, 2, &[-1.0, 0.0, 0.0, -2.0]);
    found.equal(
        "rank where a mode is not driven",
        "1",
        1.0,
        controllability_rank(&hidden, &DMatrix::from_row_slice(2, 1, &[1.0, 0.0]))? as f64,
    );
    Ok(())
}

fn seen(_: &Lab, found: &mut Found) -> Computed {
    let (a, _, c) = plant();
    found.nothing(
        "[C; C A] as stated",
        "1",
        0.0,
        (observability(&a, &c)? - DMatrix::from_rows(&[c.row(0), (&c * &a).row(0)])).norm(),
    );
    found.equal("its rank", "1", 2.0, observability_rank(&a, &c)? as f64);
    let hidden = DMatrix::from_row_slice(2, 2, &[-1.0, 0.0, 0.0, -2.0]);
    found.equal(
        "rank where a mode does not show",
        "1",
        1.0,
        observability_rank(&hidden, &DMatrix::from_row_slice(1, 2, &[1.0, 0.0]))? as f64,
    );
    Ok(())
}

/// Largest distance of a wanted pole to the nearest that is there.
fn off(a: &DMatrix<f64>, wanted: &[Complex<f64>]) -> Tried<f64> {
    let got = eigenvalues(a)?;
    let nearest = |pole: &Complex<f64>| got.iter().map(|p| (p - pole).norm()).fold(f64::INFINITY, f64::min);
    Ok(wanted.iter().map(nearest).fold(0.0, f64::max))
}

const WANTED: [Complex<f64>; 2] = [Complex::new(-3.0, 1.0), Complex::new(-3.0, -1.0)];
const FASTER: [Complex<f64>; 2] = [Complex::new(-20.0, 0.0), Complex::new(-30.0, 0.0)];

fn fed_back(_: &Lab, found: &mut Found) -> Computed {
    let (a, b, _) = plant();
    let k = place(&a, &b, &WANTED)?;
    found.nothing("poles of A − B K off those that are wanted", "1/s", 1e-9, off(&(a - b * k), &WANTED)?);
    Ok(())
}

/// No error stays, though the plant is another than believed and a constant disturbs it.
fn robust(_: &Lab, found: &mut Found) -> Computed {
    let (a, b, c) = plant();
    let (aa, ab) = augment(&a, &b, &c)?;
    let k = place(&aa, &ab, &[WANTED[0], WANTED[1], Complex::new(-4.0, 0.0)])?;
    // u = −K (∫e, x): the plant's own gain 30 % larger, a step of 1 asked for, a push of 0.5
    let mut x: DMatrix<f64> = DMatrix::zeros(2, 1);
    let (mut integral, dt) = (0.0f64, 1e-3);
    for _ in 0..20_000 {
        let u: f64 = -(k[0] * integral + k[1] * x[0] + k[2] * x[1]);
        let rate = &a * &x + &b * (1.3 * u + 0.5);
        integral += dt * (1.0 - x[0]);
        x += rate * dt;
    }
    found.near("output of a plant 30 % off under a constant push", "1", 1.0, 1e-3, x[0]);
    found.equal("ė by ẋ, −C", "1", -1.0, aa[(0, 1)]);
    found.equal("rank of controllability", "1", 3.0, controllability_rank(&aa, &ab)? as f64);
    Ok(())
}

/// A random walk that is measured with noise: the filter's gain in closed form.
fn filtered(_: &Lab, found: &mut Found) -> Computed {
    let one = |value: f64| DMatrix::from_element(1, 1, value);
    let (q, r) = (0.04f64, 1.0f64);
    // P = P − P²/(P + r) + q, P the covariance of the prediction
    let p = 0.5 * (q + (q * q + 4.0 * q * r).sqrt());
    found.near("weight of a measurement", "1", p / (p + r), 1e-9, dlqe(&one(1.0), &one(1.0), &one(q), &one(r))?[0]);
    Ok(())
}

/// The loop over estimate and error has the poles of both designs.
fn separated(_: &Lab, found: &mut Found) -> Computed {
    let (a, b, c) = plant();
    let (k, l) = (place(&a, &b, &WANTED)?, place_observer(&a, &c, &FASTER)?);
    let mut whole = DMatrix::zeros(4, 4);
    whole.view_mut((0, 0), (2, 2)).copy_from(&(&a - &b * &k));
    whole.view_mut((0, 2), (2, 2)).copy_from(&(&b * &k));
    whole.view_mut((2, 2), (2, 2)).copy_from(&(&a - &l * &c));
    let all: Vec<Complex<f64>> = WANTED.into_iter().chain(FASTER).collect();
    found.nothing("poles of the whole off those of both designs", "1/s", 1e-6, off(&whole, &all)?);
    Ok(())
}

pub(crate) fn rows() -> Vec<Row> {
    type Entry = (&'static str, &'static str, (&'static str, &'static str), crate::row::Compute);
    let rows: [Entry; 41] = [
        ("a model with noise", "ẋ = A x + B u + B_w w.", (CONVERT, "pub fn discretise"), sampled),
        ("its measurement", "y = C x + D u + D_v v.", (CONVERT, "pub fn discretise"), sampled),
        ("the usual model", "Without D and with v as it is.", (CONVERT, "pub fn discretise"), sampled),
        ("its noise", "Normal, with covariances Q_c and R_c.", (CONVERT, "pub fn discretise_noise"), closed_forms),
        ("the sampled model", "The state steps to the next sample.", (CONVERT, "pub fn discretise"), sampled),
        (
            "from continuous to sampled",
            "A_d, B_d, Q_d, R_d by exponentials and their integrals.",
            (CONVERT, "pub fn discretise_noise"),
            closed_forms,
        ),
        ("A_d of a short step", "I + A Δt.", (CONVERT, "pub fn discretise"), short_steps),
        ("B_d of a short step", "B Δt.", (CONVERT, "pub fn discretise"), short_steps),
        ("Q_d of a short step", "B_w Q B_wᵀ Δt.", (CONVERT, "pub fn discretise_noise"), short_steps),
        ("both from one exponential", "e of [A B; 0 0] Δt is [A_d B_d; 0 I].", (CONVERT, "[A_d B_d; 0 I]"), van_loan),
        ("the noise from one exponential", "e of [−A Q; 0 Aᵀ] Δt.", (CONVERT, "Van Loan's exponential"), van_loan),
        ("A_d from it", "C_22ᵀ.", (CONVERT, "Van Loan's exponential"), van_loan),
        ("Q_d from it", "C_22ᵀ C_12.", (CONVERT, "Van Loan's exponential"), van_loan),
        ("a nonlinear system", "ẋ = f(x, u, w, t).", (DERIVE, "pub fn jacobian"), linearisation),
        ("its measurement", "y = h(x, v, t).", (DERIVE, "pub fn jacobian"), linearisation),
        ("deviation of the state", "From the operating point.", (DERIVE, "pub fn jacobian"), linearisation),
        ("deviation of the input", "From the operating point.", (DERIVE, "pub fn jacobian"), linearisation),
        ("its Taylor series", "First order in each.", (DERIVE, "pub fn jacobian"), linearisation),
        ("that of the measurement", "First order in each.", (DERIVE, "pub fn jacobian"), linearisation),
        ("the linear system", "δẋ = F δx + G δu + G_w w.", (DERIVE, "pub fn jacobian"), linearisation),
        ("its measurement", "y = H δx + v.", (DERIVE, "pub fn jacobian"), linearisation),
        ("F and G", "Matrices of partial derivatives.", (DERIVE, "pub fn jacobian"), linearisation),
        ("G_w and H", "The same.", (DERIVE, "pub fn jacobian"), linearisation),
        (
            "a function of several",
            "Of which one partial derivative is wanted.",
            (DERIVE, "pub fn derivative"),
            derivatives,
        ),
        (
            "a derivative by a difference",
            "Of two values a little apart; too little apart it loses its digits.",
            (DERIVE, "pub fn derivative"),
            derivatives,
        ),
        (
            "a derivative by a complex step",
            "The imaginary part over a step that can be as small as one likes.",
            (DERIVE, "pub fn derivative"),
            derivatives,
        ),
        ("controllability", "[B AB … Aⁿ⁻¹B] has full rank.", (RANK, "pub fn controllability"), reached),
        ("state feedback", "u = −K x̂.", (PLACE, "pub fn place"), fed_back),
        ("the loop it makes", "ẋ = (A − B K) x, with poles where they are wanted.", (PLACE, "pub fn place"), fed_back),
        ("the error to be driven to zero", "e = r − y.", (SERVO, "pub fn augment"), robust),
        ("the error as a state", "z = (e, ẋ).", (SERVO, "pub fn augment"), robust),
        ("the differentiated system", "In ẋ, u̇, ẇ, v̇.", (SERVO, "pub fn augment"), robust),
        (
            "the servo's system",
            "ż = [0 −C; 0 A] z + [0; B] u̇: no error stays of what is constant.",
            (SERVO, "pub fn augment"),
            robust,
        ),
        ("observability", "[C; CA; …] has full rank.", (RANK, "pub fn observability"), seen),
        ("the estimator", "A model corrected by L (y − ŷ).", (PLACE, "pub fn place_observer"), observer_error),
        ("how its error decays", "ė = (A − L C) e.", (PLACE, "pub fn place_observer"), observer_error),
        (
            "prediction and correction",
            "Sampled, an estimate is a weighted mean of prediction and \
                measurement; by known noise the weight is the Kalman filter's.",
            (RICCATI, "pub fn dlqe"),
            filtered,
        ),
        ("feedback of the estimate", "ẋ = A x − B K x + B K e.", (PLACE, "pub fn place_observer"), separated),
        ("once the error is gone", "ẋ = (A − B K) x.", (PLACE, "pub fn place"), fed_back),
        ("state and error together", "z = (x, e).", (PLACE, "pub fn place_observer"), separated),
        ("the whole loop", "Its poles are those of both designs.", (PLACE, "pub fn place_observer"), separated),
    ];
    let row = |(i, (title, states, (file, item), compute)): (usize, Entry)| {
        Row::new(A, Displayed(i as u8 + 1), title, states).code(file, item).agrees(compute)
    };
    rows.into_iter().enumerate().map(row).collect()
}
