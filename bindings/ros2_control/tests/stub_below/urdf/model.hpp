// Stub for tests alone: see README.md of this folder.
#pragma once
#include "urdf/model.h"
