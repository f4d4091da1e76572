// Names of topics and services that roscpp's libraries compose: `names_peer REMAPPINGS...`.
// Reads lines `KIND NAME`, makes what they say, and prints its topics and services in one line.
#include <actionlib/TestAction.h>
#include <actionlib/client/action_client.h>
#include <actionlib/client/simple_action_client.h>
#include <actionlib/server/action_server.h>
#include <actionlib/server/simple_action_server.h>
#include <dynamic_reconfigure/TestConfig.h>
#include <dynamic_reconfigure/server.h>
#include <message_filters/subscriber.h>
#include <ros/ros.h>
#include <std_msgs/String.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/buffer_client.h>
#include <tf2_ros/buffer_server.h>

#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <set>
#include <string>

using actionlib::TestAction;
using Config = dynamic_reconfigure_test::TestConfig;

namespace {

// The registrations of this node with the master.
std::set<std::string> registrations() {
  XmlRpc::XmlRpcValue arguments, response, state;
  arguments[0] = ros::this_node::getName();
  ros::master::execute("getSystemState", arguments, response, state, true);
  const char* words[] = {"pub ", "sub ", "srv "};
  std::set<std::string> found;
  for (int kind = 0; kind < 3; ++kind)
    for (int i = 0; i < state[kind].size(); ++i)
      for (int j = 0; j < state[kind][i][1].size(); ++j)
        if (std::string(state[kind][i][1][j]) == ros::this_node::getName())
          found.insert(words[kind] + std::string(state[kind][i][0]));
  return found;
}

template <class T>
std::shared_ptr<void> keep(T* made) {
  return std::shared_ptr<T>(made);
}

std::map<std::string, std::function<std::shared_ptr<void>(const std::string&)>> makers() {
  static tf2_ros::Buffer buffer(ros::Duration(10), false);
  ros::NodeHandle n;
  return {
      {"action_server",
       [n](const std::string& name) {
         auto made = std::make_shared<actionlib::ActionServer<TestAction>>(n, name, false);
         made->start();
         return made;
       }},
      {"simple_server",
       [n](const std::string& name) {
         auto made = std::make_shared<actionlib::SimpleActionServer<TestAction>>(n, name, false);
         made->start();
         return made;
       }},
      {"action_client",
       [n](const std::string& name) { return keep(new actionlib::ActionClient<TestAction>(n, name)); }},
      {"simple_client",
       [](const std::string& name) { return keep(new actionlib::SimpleActionClient<TestAction>(name, false)); }},
      {"buffer_server",
       [](const std::string& name) {
         auto made = std::make_shared<tf2_ros::BufferServer>(buffer, name, false);
         made->start();
         return made;
       }},
      {"buffer_client", [](const std::string& name) { return keep(new tf2_ros::BufferClient(name)); }},
      {"reconfigure_server",
       [](const std::string& name) {
         return keep(new dynamic_reconfigure::Server<Config>(ros::NodeHandle(name)));
       }},
      {"filter",
       [n](const std::string& name) {
         ros::NodeHandle handle(n);
         return keep(new message_filters::Subscriber<std_msgs::String>(handle, name, 1));
       }},
      {"handle",
       [](const std::string& name) {
         return keep(new ros::Publisher(ros::NodeHandle(name).advertise<std_msgs::String>("inner", 1)));
       }},
  };
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "names_peer");
  ros::NodeHandle keeps_running;
  ros::AsyncSpinner spinner(1);
  spinner.start();
  const auto known = makers();
  const auto before = registrations();
  std::string kind, name;
  for (std::string line; std::getline(std::cin, line) && ros::ok();) {
    kind = line.substr(0, line.find(' '));
    name = line.substr(line.find(' ') + 1);
    std::cout << "made: ";  // logging prints lines, too
    try {
      const auto made = known.at(kind)(name);
      for (const auto& each : registrations())
        if (!before.count(each)) std::cout << each << " ";
    } catch (const ros::Exception& error) {
      std::cout << "refused ";
    }
    std::cout << std::endl;
  }
}
