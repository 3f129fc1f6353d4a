#include "scene/shared_hash.h"

#include <set>

#include <gtest/gtest.h>

#include "scene/message_visitors.h"
#include "tests/scene/scene_testing.h"

namespace tandem::scene {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// What is local, said a second time and independently of scene_fields.h.
bool is_local(const std::string& path) {
  if (path == "name" || path == "description" || path.starts_with("device.")) return true;
  const auto finger = path.find(".finger.");
  if (!path.starts_with("user.") || finger == std::string::npos) return false;
  const std::string of_finger = path.substr(path.find('.', finger + 8) + 1);
  for (const char* local :
       {"device", "hand.", "damping", "path.", "path_sine.", "force.", "force_sine."})
    if (of_finger.starts_with(local)) return true;
  return false;
}

/// Another value of the same kind. Validity does not matter: the message is only read.
void change(Message& message, const FieldDescriptor* field) {
  const auto* r = message.GetReflection();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return r->SetDouble(&message, field, r->GetDouble(message, field) * 2.0 + 0.125);
    case FieldDescriptor::CPPTYPE_INT32:
      return r->SetInt32(&message, field, r->GetInt32(message, field) + 1);
    case FieldDescriptor::CPPTYPE_BOOL:
      return r->SetBool(&message, field, !r->GetBool(message, field));
    case FieldDescriptor::CPPTYPE_ENUM:
      return r->SetEnumValue(
          &message, field,
          (r->GetEnumValue(message, field) + 1) % field->enum_type()->value_count());
    default:
      return r->SetString(&message, field, r->GetString(message, field) + "x");
  }
}

std::uint64_t hash_of(const Message& message) {
  core::Scene scene;
  std::vector<Problem> ignored;
  MessageReader reader(message, "", "a test", ignored);
  visit_scene(scene, reader);
  return shared_hash(scene);
}

TEST(SharedHash, EveryFieldChangesItUnlessItIsLocal) {
  std::set<std::string> changed;  // Message.field
  for (const core::Scene& scene : testing::scenes_with_every_field()) {
    wire::Scene message = testing::message_of(scene);
    const std::uint64_t before = hash_of(message);
    ASSERT_EQ(before, shared_hash(scene));
    testing::for_each_leaf(
        message, "", [&](Message& parent, const FieldDescriptor* field, const std::string& path) {
          const std::unique_ptr<Message> keep(parent.New());
          keep->CopyFrom(parent);
          change(parent, field);
          if (is_local(path))
            EXPECT_EQ(hash_of(message), before) << path;
          else
            EXPECT_NE(hash_of(message), before) << path;
          parent.CopyFrom(*keep);
          changed.insert(parent.GetDescriptor()->name() + "." + field->name());
        });
    ASSERT_EQ(hash_of(message), before);
  }
  const auto* file = wire::Scene::descriptor()->file();
  for (int m = 0; m < file->message_type_count(); ++m)
    for (int f = 0; f < file->message_type(m)->field_count(); ++f) {
      const auto* field = file->message_type(m)->field(f);
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) continue;
      EXPECT_TRUE(changed.contains(file->message_type(m)->name() + "." + field->name()))
          << file->message_type(m)->name() << "." << field->name() << " is in no scene of the test";
    }
}

TEST(SharedHash, PresenceAndOrderOfSharedThingsCount) {
  const core::Scene scene = load_scene("box_distributed");
  core::Scene other = scene;
  other.silence.reset();
  EXPECT_NE(shared_hash(other), shared_hash(scene));
  other = scene;
  std::swap(other.users[0], other.users[1]);
  EXPECT_NE(shared_hash(other), shared_hash(scene));
  other = scene;
  other.walls.pop_back();
  EXPECT_NE(shared_hash(other), shared_hash(scene));
  other = scene;
  other.users[0].fingers.pop_back();
  EXPECT_NE(shared_hash(other), shared_hash(scene));
  other = scene;
  other.couplers[4].copy.clear();
  EXPECT_NE(shared_hash(other), shared_hash(scene));
}

TEST(SharedHash, LocalThingsMayDifferInNumberAndOrder) {
  const core::Scene scene = load_scene("box_distributed");
  core::Scene other = scene;
  other.devices.clear();
  for (auto& user : other.users)
    for (auto& finger : user.fingers) {
      finger.device.clear();
      finger.intent = {};
    }
  EXPECT_EQ(shared_hash(other), shared_hash(scene));
}

TEST(SharedHash, FormattingCommentsDefaultsAndOrderOfFieldsDoNotCount) {
  const std::string plain =
      "scene_version: 1 object { name: \"box\" mass: 0.4 }"
      "coupler { name: \"k\" object: \"box\" user: \"1\" stiffness: 1000 damping: 10 }"
      "user { name: \"1\" finger { name: \"a\" } } architecture: SINGLE space: AXIS";
  const std::string other =
      "# a comment\narchitecture: SINGLE\nspace: AXIS\nscene_version: 1\n"
      "user: { finger: { name: 'a' position { x: -0.0 } } name: '1' mass: 1e-1 }\n"
      "contact { attached: true }\n"
      "object: <mass: 4e-1, name: 'box', shape: POINT>\n"
      "coupler: { damping: 10.0; stiffness: 1.0e3; user: '1' object: 'box' name: 'k' }\n"
      "rates { local_hz: 1024 packet_hz: 128 }";
  EXPECT_EQ(shared_hash(load_scene_text(plain, "a")), shared_hash(load_scene_text(other, "b")));
}

}  // namespace
}  // namespace tandem::scene
