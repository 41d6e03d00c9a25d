//! The heating circuit in the on-phase, healthy or faulty: supply, switch, shunt and leads in series, then the contact
//! at the moving end, then the wire down to the fixed end, which is ground.

/// What may be wrong in it. The default is nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Defects {
    /// The wire is interrupted between the second tap and the moving end.
    pub open: bool,
    /// Ω that bridge the wire.
    pub bridge_ohm: Option<f64>,
    /// Ω at the moving end, inside V_3.
    pub contact_ohm: f64,
    /// Ω in the output stage beyond what it has when it conducts well.
    pub stage_ohm: f64,
}

/// Currents and voltages of the on-phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Flow {
    /// Through the shunt, A.
    pub total_a: f64,
    /// Through the wire, A.
    pub wire_a: f64,
    /// At the moving end's terminal, V.
    pub v3_v: f64,
}

/// Below this the circuit's resistance cannot fall: no supply gives an infinite current.
const LEAST_OHM: f64 = 1e-6;

/// Solves the circuit for a wire of `wire_ohm`.
#[inline]
pub(crate) fn flow(supply_v: f64, series_ohm: f64, wire_ohm: f64, defects: &Defects) -> Flow {
    if defects.open {
        // nothing loads the supply, so all of it stands at the terminal
        return Flow { total_a: 0.0, wire_a: 0.0, v3_v: supply_v };
    }
    let bridged_ohm = match defects.bridge_ohm {
        Some(bridge) => wire_ohm * bridge / (wire_ohm + bridge).max(LEAST_OHM),
        None => wire_ohm,
    };
    let total_a = supply_v / (series_ohm + defects.stage_ohm + defects.contact_ohm + bridged_ohm).max(LEAST_OHM);
    Flow {
        total_a,
        wire_a: total_a * bridged_ohm / wire_ohm.max(LEAST_OHM),
        v3_v: total_a * (bridged_ohm + defects.contact_ohm),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: Defects = Defects { open: false, bridge_ohm: None, contact_ohm: 0.0, stage_ohm: 0.0 };

    #[test]
    fn ohms_law_holds_in_every_state() {
        let f = flow(6.0, 0.12, 10.0, &WHOLE);
        assert!((f.total_a - 6.0 / 10.12).abs() < 1e-12 && f.wire_a == f.total_a);
        assert!((f.v3_v - f.total_a * 10.0).abs() < 1e-12);

        let f = flow(6.0, 0.12, 10.0, &Defects { contact_ohm: 0.5, ..WHOLE });
        assert!((f.v3_v - 6.0 * 10.5 / 10.62).abs() < 1e-12, "contact lies inside V_3: {f:?}");

        let f = flow(6.0, 0.12, 10.0, &Defects { stage_ohm: 5.0, ..WHOLE });
        assert!((f.total_a - 6.0 / 15.12).abs() < 1e-12 && (f.v3_v - f.total_a * 10.0).abs() < 1e-12, "{f:?}");

        let f = flow(6.0, 0.12, 10.0, &Defects { bridge_ohm: Some(10.0), ..WHOLE });
        assert!((f.total_a - 6.0 / 5.12).abs() < 1e-12 && (f.wire_a - 0.5 * f.total_a).abs() < 1e-12);

        let f = flow(6.0, 0.12, 10.0, &Defects { open: true, ..WHOLE });
        assert_eq!(f, Flow { total_a: 0.0, wire_a: 0.0, v3_v: 6.0 });
    }

    #[test]
    fn a_dead_short_across_nothing_is_finite() {
        let f = flow(6.0, 0.0, 10.0, &Defects { bridge_ohm: Some(0.0), ..WHOLE });
        assert!(f.total_a.is_finite() && f.wire_a == 0.0 && f.v3_v == 0.0, "{f:?}");
    }
}
