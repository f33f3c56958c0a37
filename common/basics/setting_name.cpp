// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "setting_name.h"

#include <algorithm>

namespace programs {
namespace {

SettingNames current = SettingNames::Options;

} // namespace

void setSettingNames(SettingNames names) { current = names; }

std::string settingName(const std::string& words) {
  if (current == SettingNames::Options) return "--" + words;
  std::string name = words;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

} // namespace programs
