// SPDX-License-Identifier: Apache-2.0
// TinyGLTF's code, compiled here, so that it is built without a picture decoder of its own.
#define TINYGLTF_IMPLEMENTATION
#include "gltf.hpp"
