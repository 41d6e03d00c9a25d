// Stub for tests alone: see README.md of this folder.
#pragma once
#include "libstatistics_collector/moving_average_statistics/types.hpp"

namespace libstatistics_collector::moving_average_statistics {
struct MovingAverageStatistics {
    StatisticData GetStatistics() const { return {}; }
    void AddMeasurement(double) {}
    void Reset() {}
};
}  // namespace libstatistics_collector::moving_average_statistics
