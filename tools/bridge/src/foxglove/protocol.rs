//! The Foxglove WebSocket protocol (<https://github.com/foxglove/ws-protocol>): what a server sends, and what it hears.

use serde::{Deserialize, Serialize};
use sinew_recording::session::{MESSAGE_ENCODING, SCHEMA_ENCODING, Topic};

/// The names it goes by; the messages used here are the same in both.
pub const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// First byte of a binary message with data of a topic.
const MESSAGE_DATA: u8 = 1;

/// What a server says in JSON.
#[derive(Debug, Serialize)]
#[serde(tag = "op", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum Said<'a> {
    /// Who it is; the first message. It can do nothing but send.
    ServerInfo { name: &'a str, capabilities: [&'a str; 0], session_id: &'a str },
    /// Topics that can be subscribed to.
    Advertise { channels: &'a [Channel] },
    /// Topics that are no more.
    Unadvertise { channel_ids: &'a [u32] },
    /// For the person in front of the screen; takes the place of an earlier one with this id.
    Status { level: Level, message: &'a str, id: &'a str },
    /// Such words are no longer so.
    RemoveStatus { status_ids: [&'a str; 1] },
}

/// How grave a status is.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(into = "u8")]
pub enum Level {
    Warning = 1,
    Error = 2,
}

impl From<Level> for u8 {
    fn from(level: Level) -> u8 {
        level as u8
    }
}

/// A topic as it is advertised.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Channel {
    pub id: u32,
    topic: &'static str,
    encoding: &'static str,
    schema_name: &'static str,
    schema: String,
    schema_encoding: &'static str,
}

impl Channel {
    /// A topic under this number.
    pub fn new(id: u32, Topic { name, kind, schema }: Topic) -> Channel {
        Channel {
            id,
            topic: name,
            encoding: MESSAGE_ENCODING,
            schema_name: kind,
            schema,
            schema_encoding: SCHEMA_ENCODING,
        }
    }
}

/// What a viewer says. All else is for servers that can do more than send.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum Heard {
    /// Messages of these topics, please.
    Subscribe { subscriptions: Vec<Subscription> },
    /// No more of them.
    Unsubscribe { subscription_ids: Vec<u32> },
    #[serde(other)]
    Other,
}

/// A viewer's number for a topic's messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Subscription {
    pub id: u32,
    pub channel_id: u32,
}

/// A message of a topic, for this subscription.
pub fn data(subscription: u32, unix_ns: u64, message: &[u8]) -> Vec<u8> {
    let mut frame = Vec::with_capacity(13 + message.len());
    frame.push(MESSAGE_DATA);
    frame.extend(subscription.to_le_bytes());
    frame.extend(unix_ns.to_le_bytes());
    frame.extend_from_slice(message);
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    fn json(said: &Said<'_>) -> serde_json::Value {
        serde_json::to_value(said).unwrap()
    }

    #[test]
    fn what_is_said_is_as_the_protocol_has_it() {
        let info = Said::ServerInfo { name: "sinew: bench", capabilities: [], session_id: "7" };
        let expected =
            serde_json::json!({ "op": "serverInfo", "name": "sinew: bench", "capabilities": [], "sessionId": "7" });
        assert_eq!(json(&info), expected);
        let topic = Topic { name: "/events", kind: "sinew_msgs/msg/Event", schema: "string text\n".into() };
        let channels = [Channel::new(5, topic)];
        let expected = serde_json::json!({ "op": "advertise", "channels": [{
            "id": 5, "topic": "/events", "encoding": "cdr", "schemaName": "sinew_msgs/msg/Event",
            "schema": "string text\n", "schemaEncoding": "ros2msg",
        }] });
        assert_eq!(json(&Said::Advertise { channels: &channels }), expected);
        let expected = serde_json::json!({ "op": "unadvertise", "channelIds": [5] });
        assert_eq!(json(&Said::Unadvertise { channel_ids: &[5] }), expected);
        let expected = serde_json::json!({ "op": "status", "level": 1, "message": "slow", "id": "lost" });
        assert_eq!(json(&Said::Status { level: Level::Warning, message: "slow", id: "lost" }), expected);
        let expected = serde_json::json!({ "op": "removeStatus", "statusIds": ["driver"] });
        assert_eq!(json(&Said::RemoveStatus { status_ids: ["driver"] }), expected);
        assert_eq!(data(3, 0x0102, &[9]), [1, 3, 0, 0, 0, 2, 1, 0, 0, 0, 0, 0, 0, 9]);
    }

    #[test]
    fn what_a_viewer_says_is_understood_and_what_is_for_others_is_told_apart() {
        let heard = |text: &str| serde_json::from_str::<Heard>(text);
        let Ok(Heard::Subscribe { subscriptions }) =
            heard(r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3}]}"#)
        else {
            panic!()
        };
        assert_eq!(subscriptions, [Subscription { id: 0, channel_id: 3 }]);
        let gone = heard(r#"{"op":"unsubscribe","subscriptionIds":[0,1]}"#);
        assert!(matches!(gone, Ok(Heard::Unsubscribe { subscription_ids }) if subscription_ids == [0, 1]));
        assert!(matches!(heard(r#"{"op":"getParameters","parameterNames":[]}"#), Ok(Heard::Other)));
        for odd in
            ["", "7", "{}", r#"{"op":"subscribe"}"#, r#"{"op":"subscribe","subscriptions":[{"id":-1,"channelId":3}]}"#]
        {
            assert!(heard(odd).is_err(), "{odd}");
        }
    }
}
