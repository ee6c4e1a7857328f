"""Problem definitions: materials, bodies, webs, schedules, problems; immutable, validated."""
