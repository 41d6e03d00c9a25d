//! `[demonstrator]`: the machine that a simulated wire moves, and what a robot program sees of it.

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::MAX_CHANNEL_NAME;

words! {
    /// A machine of chapter 12.
    pub enum DemonstratorKind, default None {
        /// None: the wires move their loads.
        None = "none",
        /// A beam that one wire tilts, and a ball on it that rolls; a camera sees the ball.
        BallOnBeam = "ball_on_beam",
        /// A lever that one wire turns; a receiver hands over the widths of the pulses it is commanded by.
        Servo = "servo",
        /// An arm of two links, a wire to each joint; a camera at its tip sees a target.
        Arm = "arm",
        /// A body on six legs of three wires each, which stands on the ground by friction; a compass with a level tells how it lies.
        Hexapod = "hexapod",
        /// A torso with two arms of four wires each and a paddle in its right hand, on which a ball rolls; potentiometers tell the angles, a camera sees
        /// the ball.
        Torso = "torso",
    }
}

impl DemonstratorKind {
    /// How many wires move it.
    pub fn wires(self) -> usize {
        match self {
            DemonstratorKind::None => 0,
            DemonstratorKind::BallOnBeam | DemonstratorKind::Servo => 1,
            DemonstratorKind::Arm => 2,
            DemonstratorKind::Hexapod => 18,
            DemonstratorKind::Torso => 8,
        }
    }
}

/// Keys that only a ball on a beam has.
fn with_beam() -> Only<Demonstrator> {
    Only::new(
        |demonstrator, _| demonstrator.kind == DemonstratorKind::BallOnBeam,
        |_, _| "makes no sense without a beam; take it out, or set kind = \"ball_on_beam\"".into(),
    )
}

/// Keys that only what has a ball has.
fn with_ball() -> Only<Demonstrator> {
    Only::new(
        |demonstrator, _| matches!(demonstrator.kind, DemonstratorKind::BallOnBeam | DemonstratorKind::Torso),
        |_, _| "makes no sense without a ball; take it out, or set kind = \"ball_on_beam\" or \"torso\"".into(),
    )
}

/// Keys that only an arm has.
fn with_elbow() -> Only<Demonstrator> {
    Only::new(
        |demonstrator, _| demonstrator.kind == DemonstratorKind::Arm,
        |_, _| "makes no sense without an arm; take it out, or set kind = \"arm\"".into(),
    )
}

/// Keys that only what has arms has.
fn with_links() -> Only<Demonstrator> {
    Only::new(
        |demonstrator, _| matches!(demonstrator.kind, DemonstratorKind::Arm | DemonstratorKind::Torso),
        |_, _| "makes no sense without links; take it out, or set kind = \"arm\" or \"torso\"".into(),
    )
}

/// Keys that only a torso has.
fn with_paddle() -> Only<Demonstrator> {
    Only::new(
        |demonstrator, _| demonstrator.kind == DemonstratorKind::Torso,
        |_, _| "makes no sense without a paddle; take it out, or set kind = \"torso\"".into(),
    )
}

/// Keys that only a hexapod has.
fn with_legs() -> Only<Demonstrator> {
    Only::new(
        |demonstrator, _| demonstrator.kind == DemonstratorKind::Hexapod,
        |_, _| "makes no sense without legs; take it out, or set kind = \"hexapod\"".into(),
    )
}

/// Keys that only what has a camera has.
fn with_camera() -> Only<Demonstrator> {
    Only::new(
        |demonstrator, _| {
            matches!(demonstrator.kind, DemonstratorKind::BallOnBeam | DemonstratorKind::Arm | DemonstratorKind::Torso)
        },
        |_, _| {
            "makes no sense without a camera; take it out, or set kind = \"ball_on_beam\", \"arm\" or \"torso\"".into()
        },
    )
}

/// Keys that only a servo has.
fn with_pulses() -> Only<Demonstrator> {
    Only::new(
        |demonstrator, _| demonstrator.kind == DemonstratorKind::Servo,
        |_, _| "makes no sense without pulses; take it out, or set kind = \"servo\"".into(),
    )
}

table! {
    "demonstrator", check fits_together:
    "A machine that a simulated wire moves at the end of a lever, and what a robot program sees of it (chapter 12): `sinew demo` runs it. \
     What turns with the wire (the beam's inertia, friction and spring, by the lever's square) is the wire's `[channel.load]`.";

    /// A machine of chapter 12 that a simulated wire moves, and what a robot program sees of it.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Demonstrator {
        /// Which machine.
        kind: DemonstratorKind = "kind", DemonstratorKind::KIND, DemonstratorKind::DEFAULT;
        /// Channel whose wire moves it; of an arm, its shoulder; of a hexapod the first of eighteen: front left, front right, middle left, middle
        /// right, rear left, rear right, of each coxa, femur and tibia; of a torso the first of eight: right and left, of each shoulder, elbow, pitch
        /// and roll of the wrist.
        channel: Option<String> = "channel", name(MAX_CHANNEL_NAME), Computed("the first channel");
        /// Channel whose wire moves the elbow of an arm.
        elbow_channel: Option<String> = "elbow_channel", name(MAX_CHANNEL_NAME), Computed("the second channel"), only with_elbow();
        /// Lever that the wire pulls at: it turns by the wire's way over this, forward where the wire is shorter.
        lever_m: f64 = "lever_mm", number(milli("mm"), 0.1, 10_000.0), Number(10.0);
        /// Stroke of the wire at which the angle is zero.
        level_stroke: f64 = "level_stroke", number(si("1"), 0.0, 1.0), Number(0.5);
        /// How long the beam is to either side, from pivot to end.
        half_beam_m: f64 = "half_beam_mm", number(milli("mm"), 1.0, 10_000.0), Number(120.0), only with_beam();
        /// Mass of the ball.
        ball_kg: f64 = "ball_g", number(milli("g"), 0.001, 100_000.0), Number(3.0), only with_ball();
        /// What of its mass resists rolling besides: moment of inertia over m r², 2/5 of a solid ball, 2/3 of a hollow one.
        ball_inertia: f64 = "ball_inertia", number(si("1"), 0.0, 1.0), Number(0.4), only with_ball();
        /// Rolling resistance, as a share of the ball's weight.
        rolling_resistance: f64 = "rolling_resistance", number(si("1"), 0.0, 1.0), Number(0.001), only with_ball();
        /// Where a hand puts the ball down once beam or paddle is level, from the middle; on a paddle in a direction by chance (`seed` in
        /// `[simulation]`).
        start_m: f64 = "start_mm", number(milli("mm"), -10_000.0, 10_000.0), Number(30.0), only with_ball();
        /// From shoulder to elbow.
        upper_link_m: f64 = "upper_link_mm", number(milli("mm"), 1.0, 100_000.0), Number(150.0), only with_links();
        /// From elbow to camera, or to a torso's wrist.
        lower_link_m: f64 = "lower_link_mm", number(milli("mm"), 1.0, 100_000.0), Number(120.0), only with_links();
        /// Where the upper link points at `level_stroke`, from the horizontal.
        shoulder_rad: f64 = "shoulder_degrees", number(DEGREES, -360.0, 360.0), Number(70.0), only with_links();
        /// By how much the lower link is turned from the upper one there.
        elbow_rad: f64 = "elbow_degrees", number(DEGREES, -360.0, 360.0), Number(-70.0), only with_links();
        /// Mass of an upper arm of a torso, in its middle; what that turns with is its wire's load.
        upper_link_kg: f64 = "upper_link_g", number(milli("g"), 0.0, 100_000.0), Number(10.0), only with_paddle();
        /// Mass of a forearm, in its middle.
        lower_link_kg: f64 = "lower_link_g", number(milli("g"), 0.0, 100_000.0), Number(8.0), only with_paddle();
        /// Mass of the paddle, whose middle is at the wrist.
        paddle_kg: f64 = "paddle_g", number(milli("g"), 0.0, 100_000.0), Number(8.0), only with_paddle();
        /// From the middle of the paddle to its edge; it is round, and level at `level_stroke`.
        paddle_radius_m: f64 = "paddle_radius_mm", number(milli("mm"), 1.0, 10_000.0), Number(80.0), only with_paddle();
        /// Noise of the angle that a potentiometer says, RMS.
        potentiometer_noise_rad: f64 = "potentiometer_noise_degrees", number(DEGREES, 0.0, 90.0), Number(0.2), only with_paddle();
        /// Mass of a hexapod.
        body_kg: f64 = "body_g", number(milli("g"), 1.0, 100_000.0), Number(60.0), only with_legs();
        /// From one leg of a side to the next.
        leg_spacing_m: f64 = "leg_spacing_mm", number(milli("mm"), 1.0, 10_000.0), Number(60.0), only with_legs();
        /// From the hips of one side to those of the other.
        hip_width_m: f64 = "hip_width_mm", number(milli("mm"), 1.0, 10_000.0), Number(50.0), only with_legs();
        /// How far the belly hangs below the hips: where it touches the ground the machine has fallen.
        belly_m: f64 = "belly_mm", number(milli("mm"), 1.0, 1000.0), Number(8.0), only with_legs();
        /// From the hip's upright axis to the level one of the femur.
        coxa_m: f64 = "coxa_mm", number(milli("mm"), 0.0, 10_000.0), Number(12.0), only with_legs();
        /// From hip to knee.
        femur_m: f64 = "femur_mm", number(milli("mm"), 1.0, 10_000.0), Number(30.0), only with_legs();
        /// From knee to foot.
        tibia_m: f64 = "tibia_mm", number(milli("mm"), 1.0, 10_000.0), Number(50.0), only with_legs();
        /// How far the femur rises from the hip to the knee, at `level_stroke`.
        femur_rad: f64 = "femur_degrees", number(DEGREES, -90.0, 90.0), Number(20.0), only with_legs();
        /// How far outwards the tibia leans from the plumb line there.
        tibia_rad: f64 = "tibia_degrees", number(DEGREES, -90.0, 90.0), Number(10.0), only with_legs();
        /// Stiffness of a foot with its leg, both down and along the ground.
        foot_n_per_m: f64 = "foot_n_per_m", number(si("N/m"), 50.0, 2000.0), Number(600.0), only with_legs();
        /// Coefficient of friction between foot and ground.
        friction: f64 = "friction", number(si("1"), 0.0, 10.0), Number(0.7), only with_legs();
        /// The ground rises so much ahead.
        slope_rad: f64 = "slope_degrees", number(DEGREES, -45.0, 45.0), Number(0.0), only with_legs();
        /// By so much each foothold is higher or lower than the plane, RMS, by chance; no more than two and a half times this.
        unevenness_m: f64 = "unevenness_mm", number(milli("mm"), 0.0, 100.0), Number(0.5), only with_legs();
        /// Where it is put down to look, to the left of straight ahead.
        heading_rad: f64 = "heading_degrees", number(DEGREES, -180.0, 180.0), Number(5.0), only with_legs();
        /// Noise of the angles that its compass and level say, RMS.
        compass_noise_rad: f64 = "compass_noise_degrees", number(DEGREES, 0.0, 90.0), Number(1.0), only with_legs();
        /// Pictures of the camera, pulses of the receiver or words of the compass a second.
        sensor_hz: f64 = "sensor_hz", number(si("Hz"), 1.0, 1000.0), Number(50.0);
        /// How old what it says is when it comes.
        sensor_delay_s: f64 = "sensor_delay_ms", number(milli("ms"), 0.0, 1000.0), Number(20.0);
        /// Noise of a place the camera sees, RMS.
        camera_noise_m: f64 = "camera_noise_mm", number(milli("mm"), 0.0, 1000.0), Number(0.5), only with_camera();
        /// Jitter of a pulse's width, RMS.
        jitter_s: f64 = "jitter_us", number(micro("µs"), 0.0, 1000.0), Number(0.5), only with_pulses();
        /// Width of the pulse that asks for the angle zero.
        centre_pulse_s: f64 = "centre_pulse_us", number(micro("µs"), 100.0, 10_000.0), Number(1500.0), only with_pulses();
        /// Angle that a pulse wider by 1 ms asks for.
        rad_per_s: f64 = "degrees_per_ms", number(DEGREES_PER_MS, -10_000.0, 10_000.0), Number(60.0), only with_pulses();
        /// A draught takes so much more heat from the wire, as a share of what the still air takes.
        draught: f64 = "draught", number(si("1"), 0.0, 100.0), Number(0.5);
        /// For so long it blows.
        draught_s: f64 = "draught_for_s", number(si("s"), 0.0, 1e6), Number(3.0);
        /// So long from one to the next on average, by chance (`seed` in `[simulation]`); 0 = never.
        draught_every_s: f64 = "draught_every_s", number(si("s"), 0.0, 1e6), Number(20.0);
    }
}

const DEGREES: Unit = Unit::new("°", std::f64::consts::PI / 180.0, 1.0);

/// One degree a millisecond, in rad/s.
const DEGREES_PER_MS: Unit = Unit::new("°/ms", std::f64::consts::PI / 180.0 * 1e3, 1.0);

fn fits_together(reader: &mut Reader<'_>, demonstrator: &Demonstrator, stated: &Stated<'_>) {
    let mut refuse = |key: &'static str, message: String| {
        let line = stated.line_of_first(&[("demonstrator", key), ("demonstrator", "kind")]);
        reader.problem(line, None, format!("demonstrator.{key}"), What::Contradiction { message });
    };
    let Demonstrator { start_m, half_beam_m, draught_s, draught_every_s, .. } = *demonstrator;
    if demonstrator.kind == DemonstratorKind::BallOnBeam && start_m.abs() >= half_beam_m {
        let (start, half) = (start_m * 1e3, half_beam_m * 1e3);
        refuse("start_mm", format!("is {start}, beside the beam, which ends {half} mm from its pivot"));
    }
    if demonstrator.kind == DemonstratorKind::Torso && start_m.abs() >= demonstrator.paddle_radius_m {
        let (start, radius) = (start_m * 1e3, demonstrator.paddle_radius_m * 1e3);
        refuse("start_mm", format!("is {start}, beside the paddle, which ends {radius} mm from its middle"));
    }
    if demonstrator.kind == DemonstratorKind::Servo && demonstrator.rad_per_s == 0.0 {
        refuse("degrees_per_ms", "is 0: no pulse would turn it; expected more or less".into());
    }
    if demonstrator.kind == DemonstratorKind::Hexapod && height_m(demonstrator) <= demonstrator.belly_m {
        let (height, belly) = (height_m(demonstrator) * 1e3, demonstrator.belly_m * 1e3);
        refuse(
            "belly_mm",
            format!("is {belly}, but its legs lift the hips by {height:.1} mm; expected less than that"),
        );
    }
    if draught_every_s > 0.0 && draught_every_s <= draught_s {
        refuse("draught_every_s", format!("is {draught_every_s}, expected more than draught_for_s, {draught_s}"));
    }
}

/// How high the hips of a hexapod are above its feet at `level_stroke`, m.
fn height_m(demonstrator: &Demonstrator) -> f64 {
    demonstrator.tibia_m * demonstrator.tibia_rad.cos() - demonstrator.femur_m * demonstrator.femur_rad.sin()
}
