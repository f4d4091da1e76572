// Server and client of actions in roscpp: `action_peer server` and `action_peer client`.
// Both use actionlib's TestRequest; the client prints what became of each goal.
#include <actionlib/TestRequestAction.h>
#include <actionlib/client/simple_action_client.h>
#include <actionlib/server/simple_action_server.h>
#include <ros/ros.h>

#include <iostream>
#include <string>

using actionlib::TestRequestAction;
using actionlib::TestRequestFeedback;
using actionlib::TestRequestGoal;
using actionlib::TestRequestResult;
using Server = actionlib::SimpleActionServer<TestRequestAction>;
using Client = actionlib::SimpleActionClient<TestRequestAction>;

namespace {

void execute(Server* server, const actionlib::TestRequestGoalConstPtr& goal) {
  TestRequestResult result;
  result.the_result = goal->the_result;
  result.is_simple_server = true;
  if (goal->pause_status.toSec() < 0) {
    while (!server->isPreemptRequested() && ros::ok()) ros::WallDuration(0.01).sleep();
    server->setPreempted(result, "stopped");
    return;
  }
  for (int count = 0; count < 3; ++count) server->publishFeedback(TestRequestFeedback());
  if (goal->terminate_status == TestRequestGoal::TERMINATE_SUCCESS)
    server->setSucceeded(result, goal->result_text);
  else
    server->setAborted(result, goal->result_text);
}

void tell(Client& client, const char* what) {
  const auto state = client.getState();
  std::cout << what << " " << state.toString() << " " << client.getResult()->the_result << " " << state.getText()
            << std::endl;
}

int ask() {
  Client client("action", true);
  if (!client.waitForServer(ros::Duration(20))) return 1;
  TestRequestGoal goal;
  for (int kind = 0; kind < 2; ++kind) {
    goal.terminate_status = kind;
    goal.the_result = 10 + kind;
    goal.result_text = "text";
    client.sendGoal(goal);
    if (!client.waitForResult(ros::Duration(20))) return 2;
    tell(client, "ended");
  }
  goal.pause_status = ros::Duration(-1);
  for (int all = 0; all < 2; ++all) {
    client.sendGoal(goal);
    while (client.getState() != actionlib::SimpleClientGoalState::ACTIVE && ros::ok()) ros::WallDuration(0.01).sleep();
    if (all)
      client.cancelAllGoals();
    else
      client.cancelGoal();
    if (!client.waitForResult(ros::Duration(20))) return 3;
    tell(client, "cancelled");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const bool serving = argc > 1 && std::string(argv[1]) == "server";
  ros::init(argc, argv, serving ? "server" : "client");
  ros::NodeHandle node;
  if (!serving) return ask();
  Server server(
      node, "action", [&server](const actionlib::TestRequestGoalConstPtr& goal) { execute(&server, goal); }, false);
  server.start();
  std::cout << "ready" << std::endl;
  ros::spin();
  return 0;
}
