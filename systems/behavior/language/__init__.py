"""The XML language of trees; each fault in a tree is a BehaviorTreeError."""
