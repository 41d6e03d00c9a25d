//! What can be wrong with a board off the bench: every cause that a bring-up names, with its remedy.

use serde::Serialize;

/// Makes of the table [`Cause`] and what there is to say of each.
macro_rules! causes {
    ($( $cause:ident = $id:literal { $says:literal, $remedy:literal } )+) => {
        /// A named cause.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
        pub enum Cause {
            $( #[doc = $says] #[serde(rename = $id)] $cause, )+
        }

        impl Cause {
            /// Its name in reports.
            pub fn id(self) -> &'static str {
                match self { $( Cause::$cause => $id, )+ }
            }

            /// What it is.
            pub fn says(self) -> &'static str {
                match self { $( Cause::$cause => $says, )+ }
            }

            /// What to do about it.
            pub fn remedy(self) -> &'static str {
                match self { $( Cause::$cause => $remedy, )+ }
            }
        }
    };
}

causes! {
    SupplyOff = "supply_off" {
        "there is no supply, or its sense line does not see it",
        "switch the supply on and measure it at the board's terminals; if it is there, look at the sense line's divider, and for a pressed emergency stop or a fuse before it"
    }
    SupplySense = "supply_sense" {
        "the supply is there, but its sense line shows nothing: it is open, or connected the wrong way round",
        "with the supply off, follow the divider from the supply's + to the input and from there to its −, and exchange what is the wrong way round"
    }
    SupplyLow = "supply_low" {
        "the supply is lower than the rig file says",
        "set it to drive.supply_v, or write what it is into the rig file; look at its current limit and at thin leads"
    }
    SupplyHigh = "supply_high" {
        "the supply is higher than the rig file says",
        "set it to drive.supply_v before a wire is connected, or write what it is into the rig file"
    }
    StageOn = "stage_on" {
        "the stage conducts although its gate is told not to",
        "take the supply away; then look at the gate: its polarity (drive.polarity of Linux' PWM, a driver that inverts), its pull to off, a bridge of solder from drain to source, a transistor that has died. Connect no wire before this is gone"
    }
    NoSupplyAtStages = "no_supply_at_stages" {
        "no stage puts anything out: the supply does not reach them",
        "look at the enable line to the master switch ([backend.enable]: signal and polarity), at the switch, at the first contact of the emergency stop and at the fuse in the supply's lead"
    }
    StageDead = "stage_dead" {
        "nothing reaches this terminal: the stage does not conduct, or its gate gets no signal",
        "follow the gate's signal from the controller to the transistor; look at this channel's fuse, and whether the channel's index or output in the rig file is the one it is soldered to"
    }
    StageWeak = "stage_weak" {
        "more is lost between supply and terminal than stage, shunt and leads take",
        "look for a transistor that does not open fully (gate voltage, type), a bad joint, thin leads; or correct switch_ohm, shunt_ohm and lead_ohm in the rig file"
    }
    TapMissing = "tap_missing" {
        "a voltage lead does not touch what it should",
        "put its clip where the step says; if it is there, measure the lead from clip to input for a break"
    }
    TapsExchanged = "taps_exchanged" {
        "the leads of the first and the second tap are exchanged",
        "exchange V1 and V2: the first tap is the one nearer to the fixed end"
    }
    TapEndExchanged = "tap_end_exchanged" {
        "the leads of the second tap and of the moving end are exchanged",
        "exchange V2 and V3: V3 belongs to the moving end's terminal, outside of both taps"
    }
    TapsApart = "taps_apart" {
        "the taps are not where the rig file says, or the wire is not as long",
        "measure l0_mm and ls_mm between the taps with the wire taut and cold, and length_mm, and correct the rig file or the taps"
    }
    OutputsExchanged = "outputs_exchanged" {
        "this channel's output drives another channel's stage, and the other way round",
        "exchange the two gates' signals, or the outputs (pwm) of the two channels in the rig file"
    }
    SensesExchanged = "senses_exchanged" {
        "this channel's current and voltages are read by another channel, and the other way round",
        "exchange the two channels' sense leads, or the inputs of the two channels in the rig file"
    }
    ChannelsExchanged = "channels_exchanged" {
        "these terminals belong to another channel",
        "exchange the index of the two channels in [channel.front_end] (or their outputs and inputs), or the labels on the board"
    }
    LeadOpen = "lead_open" {
        "there is voltage at the terminal, but no current flows through the resistor",
        "look at the resistor's clips, the channel's fuse, and the lead from the fixed end by the shunt to ground"
    }
    ShuntValue = "shunt_value" {
        "the current is read wrongly by a factor: the shunt has another value, or the amplifier behind it another gain",
        "read the shunt's print and measure it with four leads; put the right one in, or correct adc.current_range_a with the firmware's, and shunt_ohm"
    }
    CurrentUnseen = "current_unseen" {
        "a current flows, for the terminal's voltage falls, but none is read: the shunt is bridged, or its sense lead is open",
        "look for a bridge of solder over the shunt, and follow the lead from it to the input"
    }
    Gain = "gain" {
        "a voltage is read wrongly by more than a divider's tolerance",
        "check the divider's resistors and the converter's reference; if they are what you want, repeat with --accept-gains, and the correction is written"
    }
    Offset = "offset" {
        "an input shows something where there is nothing",
        "check the input's ground lead, its amplifier's zero and for a leak; if it is what you want, repeat with --accept-gains, and the correction is written"
    }
    StopOpen = "stop_open" {
        "the emergency stop's contact is open, pressed or not: it is not connected, or its lead is broken",
        "connect the normally closed contact between the input and its pull; the reading must follow the button"
    }
    StopNormallyOpen = "stop_normally_open" {
        "the emergency stop's contact works the wrong way round: it closes when the button is pressed",
        "use the button's normally closed contact: a broken lead has to look like a pressed button; or correct backend.estop.polarity, if the contact is normally closed already"
    }
    StopBridged = "stop_bridged" {
        "the emergency stop's contact is closed, pressed or not: it is bridged, or it is another input",
        "look for a bridge over the contact, and whether this is the input the firmware looks at. Do not go on without it"
    }
    WireOpen = "wire_open" {
        "there is voltage at the terminal, but no current flows through the wire",
        "look at the crimps: one that holds the wire but has not cut through its oxide is open; then at the wire itself"
    }
    WireBridged = "wire_bridged" {
        "the wire has far too little resistance: it is bridged",
        "look for a wire that touches the frame, a tap's lead or its neighbour, and for two crimps that touch"
    }
    WrongWire = "wrong_wire" {
        "the wire's resistance is not that of the rig file's wire",
        "measure the wire's diameter and the length between its crimps, and correct wire in the rig file; a crimp of some ohms looks like a longer wire"
    }
    Unseen = "unseen" {
        "nothing was sampled",
        "see the fault; look at the line to the board and whether this machine is punctual (`sinew doctor RIG.toml`), and at the converter"
    }
    Other = "fault" {
        "the driver's supervisor has switched the channel off by a fault that this step does not explain",
        "see the fault's own remedy above"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_are_those_of_the_json() {
        let all = [Cause::SupplyOff, Cause::StageOn, Cause::Gain, Cause::Other, Cause::TapEndExchanged];
        for cause in all {
            assert_eq!(serde_json::to_value(cause).unwrap(), cause.id());
            assert!(!cause.says().is_empty() && !cause.remedy().is_empty());
        }
    }
}
