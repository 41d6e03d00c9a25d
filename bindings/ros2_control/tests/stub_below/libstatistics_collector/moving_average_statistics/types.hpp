// Stub for tests alone: see README.md of this folder.
#pragma once
#include <cstdint>

namespace libstatistics_collector::moving_average_statistics {
struct StatisticData {
    double average = 0.0, min = 0.0, max = 0.0, standard_deviation = 0.0;
    std::uint64_t sample_count = 0;
};
}  // namespace libstatistics_collector::moving_average_statistics
