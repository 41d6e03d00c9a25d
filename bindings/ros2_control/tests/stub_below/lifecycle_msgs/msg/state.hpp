// Stub for tests alone: see README.md of this folder.
#pragma once
namespace lifecycle_msgs::msg {
struct State {
    enum : unsigned char {
        PRIMARY_STATE_UNKNOWN,
        PRIMARY_STATE_UNCONFIGURED,
        PRIMARY_STATE_INACTIVE,
        PRIMARY_STATE_ACTIVE,
        PRIMARY_STATE_FINALIZED
    };
};
}  // namespace lifecycle_msgs::msg
