#include "cli/campaign/slurm.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

namespace sightline::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

CampaignCommand of_a_campaign() {
  CampaignCommand command;
  command.scenario = {.file = "/a b/c.toml", .set = {"safety.d_hard=0.7"}};
  command.runs = 100;
  command.slurm = {.submit = true, .shards = 4};
  return command;
}

TEST(Slurm, TheScriptFliesAShardInEachTask) {
  ::unsetenv("SBATCH_CPUS_PER_TASK");
  const std::string script = slurm_script(of_a_campaign(), 7, "c", "/out/d");
  EXPECT_THAT(
      script,
      AllOf(
          HasSubstr("#SBATCH --array=1-4\n"), HasSubstr("#SBATCH --cpus-per-task=1\n"),
          HasSubstr("#SBATCH --output=/out/d/shard_%a/slurm.txt\n"),
          HasSubstr("campaign '/a b/c.toml' --runs 100 --seed 7 --threads 1 --set safety.d_hard=0.7 --shard "
                    "\"$SLURM_ARRAY_TASK_ID/4\" -o /out/d/shard_\"$SLURM_ARRAY_TASK_ID\"\n")));
  EXPECT_THAT(script, AllOf(Not(HasSubstr("--partition")), Not(HasSubstr("--time"))))
      << "left to the environment and to Slurm";
}

TEST(Slurm, TheCommandComesBeforeTheEnvironment) {
  CampaignCommand command = of_a_campaign();
  command.slurm.partition = "short";
  command.slurm.time = "10:00";
  command.compare_with = "/x/y.toml";
  ::setenv("SBATCH_CPUS_PER_TASK", "3", 1);
  EXPECT_THAT(slurm_script(command, 7, "c", "/out/d"),
              AllOf(HasSubstr("#SBATCH --cpus-per-task=3\n"), HasSubstr("--threads 3"),
                    HasSubstr("#SBATCH --partition=short\n"), HasSubstr("#SBATCH --time=10:00\n"),
                    HasSubstr("--compare-with /x/y.toml")));
  command.slurm.cpus = 2;
  EXPECT_THAT(slurm_script(command, 7, "c", "/out/d"), HasSubstr("#SBATCH --cpus-per-task=2\n"));
  ::unsetenv("SBATCH_CPUS_PER_TASK");
}

}  // namespace
}  // namespace sightline::cli
