// Stub for tests alone: see README.md of this folder.
#pragma once
#include <mutex>

namespace realtime_tools {
using prio_inherit_mutex = std::mutex;
}
