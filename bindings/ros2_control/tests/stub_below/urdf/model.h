// Stub for tests alone: see README.md of this folder.
#pragma once
#include <urdf_parser/urdf_parser.h>

#include <string>

namespace urdf {
struct Model : ModelInterface {
    bool initString(const std::string &text) {
        const ModelInterfaceSharedPtr parsed = parseURDF(text);
        if (parsed) {
            static_cast<ModelInterface &>(*this) = *parsed;
        }
        return parsed != nullptr;
    }
};
}  // namespace urdf
